#include <difusa/output/form_factor_files.h>

#include <difusa/core/error.h>
#include <difusa/core/text.h>
#include <difusa/io/npz_file.h>
#include <difusa/io/whole_file.h>
#include <difusa/output/text_table.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

namespace difusa {

namespace {

/// Text is handed on in pieces of about this size.
constexpr std::size_t text_piece = 1U << 20U;

/// Collects text and writes it in pieces.
class TextPieces {
  public:
    explicit TextPieces(WholeFile& file) : file_(file) {}
    void add(std::string_view text) {
        piece_ += text;
        if (piece_.size() >= text_piece) {
            flush();
        }
    }
    void flush() {
        file_.write(piece_);
        piece_.clear();
    }

  private:
    WholeFile& file_;
    std::string piece_;
};

/// All of row i, zeros included.
std::vector<double> dense_row(const FormFactors& F, std::size_t i) {
    std::vector<double> row(F.size(), 0.0);
    for (std::size_t e = 0; e < F.rows[i].column.size(); ++e) {
        row[F.rows[i].column[e]] = F.rows[i].factor[e];
    }
    return row;
}

void write_csv_sparse(const FormFactors& F, const Surfaces& surfaces, TextPieces& text) {
    text.add("from,to,form_factor,error\n");
    for (std::size_t i = 0; i < F.size(); ++i) {
        const FormFactors::Row& row = F.rows[i];
        const std::string from = csv_quoted(surfaces.name[i]) + ",";
        for (std::size_t e = 0; e < row.column.size(); ++e) {
            text.add(from + csv_quoted(surfaces.name[row.column[e]]) + "," + exact_text(row.factor[e]) + "," +
                     text_of(row.error[e]) + "\n");
        }
        text.add(from + "\"(escapes)\"," + exact_text(1.0 - F.row_sum(i)) + "," + text_of(F.row_error(i)) + "\n");
    }
}

void write_csv_dense(const FormFactors& F, const Surfaces& surfaces, TextPieces& text) {
    text.add("surface,area");
    for (const std::string& name : surfaces.name) {
        text.add("," + csv_quoted(name));
    }
    text.add(",row_sum,escapes\n");
    for (std::size_t i = 0; i < F.size(); ++i) {
        text.add(csv_quoted(surfaces.name[i]) + "," + exact_text(F.area[i]));
        for (const double factor : dense_row(F, i)) {
            text.add("," + exact_text(factor));
        }
        const double sum = F.row_sum(i);
        text.add("," + exact_text(sum) + "," + exact_text(1.0 - sum) + "\n");
    }
}

void write_mtx(const FormFactors& F, FormFactorLayout layout, TextPieces& text) {
    const std::string n = std::to_string(F.size());
    if (layout == FormFactorLayout::dense) { // by columns
        text.add("%%MatrixMarket matrix array real general\n" + n + " " + n + "\n");
        for (std::size_t j = 0; j < F.size(); ++j) {
            for (std::size_t i = 0; i < F.size(); ++i) {
                text.add(exact_text(F.at(i, j)) + "\n");
            }
        }
        return;
    }
    text.add("%%MatrixMarket matrix coordinate real general\n" + n + " " + n + " " + std::to_string(F.nonzeros()) +
             "\n");
    for (std::size_t i = 0; i < F.size(); ++i) {
        const FormFactors::Row& row = F.rows[i];
        for (std::size_t e = 0; e < row.column.size(); ++e) {
            text.add(std::to_string(i + 1) + " " + std::to_string(row.column[e] + 1) + " " + exact_text(row.factor[e]) +
                     "\n");
        }
    }
}

/// One array of each member of some records.
template <class Number, class Record, class Member>
std::vector<Number> column_of(const std::vector<Record>& records, const Member& member) {
    std::vector<Number> numbers;
    numbers.reserve(records.size());
    for (const Record& record : records) {
        numbers.push_back(static_cast<Number>(member(record)));
    }
    return numbers;
}

/// Rows of three.
template <class Record, class Member>
std::vector<double> vectors_of(const std::vector<Record>& records, const Member& member) {
    std::vector<double> numbers;
    numbers.reserve(3 * records.size());
    for (const Record& record : records) {
        const Vec3& v = member(record);
        numbers.insert(numbers.end(), v.begin(), v.end());
    }
    return numbers;
}

std::vector<double> escapes_of(const std::vector<double>& row_sums) {
    return column_of<double>(row_sums, [](double sum) { return 1.0 - sum; });
}

void write_npz_sparse(const FormFactors& F, NpzWriter& npz) {
    std::vector<double> data;
    std::vector<float> error;
    std::vector<std::int32_t> indices;
    std::vector<std::int64_t> indptr{0};
    for (const FormFactors::Row& row : F.rows) {
        data.insert(data.end(), row.factor.begin(), row.factor.end());
        error.insert(error.end(), row.error.begin(), row.error.end());
        for (const Index j : row.column) {
            indices.push_back(static_cast<std::int32_t>(j));
        }
        indptr.push_back(static_cast<std::int64_t>(data.size()));
    }
    const auto n = static_cast<std::int64_t>(F.size());
    npz.bytes("format", "csr");
    npz.array("shape", std::vector<std::int64_t>{n, n});
    npz.array("indptr", indptr);
    npz.array("indices", indices);
    npz.array("data", data);
    npz.array("error", error);
}

void write_npz_dense(const FormFactors& F, NpzWriter& npz) {
    std::vector<double> factors;
    std::vector<float> error(F.size() * F.size(), 0.0F);
    for (std::size_t i = 0; i < F.size(); ++i) {
        const std::vector<double> row = dense_row(F, i);
        factors.insert(factors.end(), row.begin(), row.end());
        for (std::size_t e = 0; e < F.rows[i].column.size(); ++e) {
            error[i * F.size() + F.rows[i].column[e]] = F.rows[i].error[e];
        }
    }
    npz.array("form_factors", factors, F.size());
    npz.array("error", error, F.size());
}

void write_npz(const FormFactors& F, const Surfaces& surfaces, FormFactorLayout layout, WholeFile& file) {
    NpzWriter npz(file);
    if (layout == FormFactorLayout::dense) {
        write_npz_dense(F, npz);
    } else {
        write_npz_sparse(F, npz);
    }
    std::vector<double> sums;
    for (std::size_t i = 0; i < F.size(); ++i) {
        sums.push_back(F.row_sum(i));
    }
    npz.array("area", F.area);
    npz.array("row_sum", sums);
    npz.array("escapes", escapes_of(sums));
    npz.texts("names", surfaces.name);
    npz.finish();
}

} // namespace

void check_form_factor_file(const std::filesystem::path& file) {
    const std::string extension = file.extension().string();
    if (extension != ".csv" && extension != ".npz" && extension != ".mtx") {
        throw UsageError("cannot write form factors to `" + file.string() +
                         "`: the name must end in .csv (a table), .npz (NumPy, SciPy) or .mtx (Matrix Market)");
    }
}

void write_form_factors(const FormFactors& F, const Surfaces& surfaces, FormFactorLayout layout,
                        const std::filesystem::path& file) {
    check_form_factor_file(file);
    WholeFile out(file);
    const std::string extension = file.extension().string();
    if (extension == ".npz") {
        write_npz(F, surfaces, layout, out);
    } else {
        TextPieces text(out);
        if (extension == ".mtx") {
            write_mtx(F, layout, text);
        } else if (layout == FormFactorLayout::dense) {
            write_csv_dense(F, surfaces, text);
        } else {
            write_csv_sparse(F, surfaces, text);
        }
        text.flush();
    }
    out.commit();
}

void check_grouped_file(const std::filesystem::path& file) {
    if (file.extension() != ".npz") {
        throw UsageError("cannot write form factors between groups to `" + file.string() +
                         "`: the name must end in .npz (NumPy)");
    }
}

void write_form_factors(const GroupedFormFactors& F, const Surfaces& surfaces, const std::filesystem::path& file) {
    check_grouped_file(file);
    using Group = GroupedFormFactors::Group;
    using Link = GroupedFormFactors::Link;
    WholeFile out(file);
    NpzWriter npz(out);
    const auto same = [](const auto& value) -> const auto& {
        return value;
    };
    npz.array("order", column_of<std::int32_t>(F.order, same));
    npz.array("group_first", column_of<std::int32_t>(F.groups, [](const Group& g) { return g.first; }));
    npz.array("group_last", column_of<std::int32_t>(F.groups, [](const Group& g) { return g.last; }));
    npz.array("group_area", column_of<double>(F.groups, [](const Group& g) { return g.area; }));
    npz.array("group_centroid", vectors_of(F.groups, [](const Group& g) -> const Vec3& { return g.centre; }), 3);
    npz.array("link_a", column_of<std::int32_t>(F.links, [](const Link& l) { return l.a; }));
    npz.array("link_b", column_of<std::int32_t>(F.links, [](const Link& l) { return l.b; }));
    npz.array("kernel", column_of<double>(F.links, [](const Link& l) { return l.kernel; }));
    npz.array("gradient_a", vectors_of(F.links, [](const Link& l) -> const Vec3& { return l.gradient_a; }), 3);
    npz.array("gradient_b", vectors_of(F.links, [](const Link& l) -> const Vec3& { return l.gradient_b; }), 3);
    npz.array("error", column_of<float>(F.links, [](const Link& l) { return l.error; }));
    npz.array("area", F.area);
    npz.array("centroid", vectors_of(F.centroid, same), 3);
    npz.array("surface", column_of<std::int32_t>(surfaces.of, same));
    const std::vector<double> sums = F.row_sums();
    npz.array("row_sum", sums);
    npz.array("escapes", escapes_of(sums));
    npz.texts("names", surfaces.name);
    npz.finish();
    out.commit();
}

std::string table_of(const FormFactors& F, const Surfaces& surfaces, std::size_t most) {
    if (F.size() > most) {
        return {};
    }
    constexpr std::size_t widest = 16;
    const auto cell = [](const std::string& text, std::size_t width) {
        const std::string shown = text.size() > width ? text.substr(0, width) : text;
        return std::string(width - shown.size(), ' ') + shown;
    };
    const auto number = [](double value) {
        // Rounding leaves sums a little above 1, of which -1e-16 escapes.
        return formatted("%.8f", std::abs(value) < 0.5e-8 ? 0.0 : value);
    };
    std::string table = cell("from \\ to", widest);
    for (const std::string& name : surfaces.name) {
        table += " " + cell(name, 10);
    }
    table += " " + cell("row sum", 10) + " " + cell("escapes", 11) + "\n";
    for (std::size_t i = 0; i < F.size(); ++i) {
        table += cell(surfaces.name[i], widest);
        for (const double factor : dense_row(F, i)) {
            table += " " + cell(number(factor), 10);
        }
        const double sum = F.row_sum(i);
        table += " " + cell(number(sum), 10) + " " + cell(number(1.0 - sum), 11) + "\n";
    }
    return table;
}

} // namespace difusa
