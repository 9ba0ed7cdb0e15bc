#include <difusa/output/form_factor_files.h>

#include <difusa/core/error.h>
#include <difusa/core/text.h>
#include <difusa/io/npz_file.h>
#include <difusa/io/whole_file.h>

#include <algorithm>
#include <cstdio>
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
    std::vector<double> sums, escapes;
    for (std::size_t i = 0; i < F.size(); ++i) {
        sums.push_back(F.row_sum(i));
        escapes.push_back(1.0 - sums.back());
    }
    npz.array("area", F.area);
    npz.array("row_sum", sums);
    npz.array("escapes", escapes);
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
        char text[32];
        std::snprintf(text, sizeof text, "%.8f", value);
        return std::string(text);
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
