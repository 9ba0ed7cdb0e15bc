// Where each program starts: at the function `program` in its namespace. The programs are compiled together, because
// nearly all of the time goes into the headers of CLI11, which they share.
namespace DIFUSA_PROGRAM {

int program(int count, char** words);

} // namespace DIFUSA_PROGRAM

int main(int count, char** words) {
    return DIFUSA_PROGRAM::program(count, words);
}
