// A shared object that has nothing to do with difusa.
extern "C" int difusa_test_not_a_plugin();
extern "C" int difusa_test_not_a_plugin() {
    return 1;
}
