#include <difusa/discretisation/projection.h>

#include <difusa/algebra/column_panels.h>
#include <difusa/algebra/wide_vectors.h>
#include <difusa/core/error.h>
#include <difusa/core/parallel.h>
#include <difusa/core/text.h>
#include <difusa/mesh/point_tree.h>
#include <difusa/mesh/surface_sampling.h>

#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>
#include <Eigen/SparseLU>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

namespace difusa {

/// values -> coefficients as a linear map with a transpose.
struct Projection::Map {
    virtual ~Map() = default;
    virtual Values apply(const Values& values, const Execution& execution) const = 0;
    virtual void apply_single(const SingleValues& values, SingleValues& result, SingleValues& /*scratch*/,
                              const Execution& execution) const {
        result = apply(Values(values.cast<double>()), execution).cast<float>();
    }
    virtual Values transposed(const Values& coefficients) const = 0;
    virtual bool is_identity() const { return false; }
    virtual bool is_mean() const { return false; }
    virtual double condition() const { return 1.0; }
    virtual std::optional<SparseRows> matrix() const { return {}; }
    virtual std::size_t entry_count() const = 0;

    struct Identity;
    struct PatchMeans;
    struct Inverse;
    struct Correction;
    struct LeastSquares;
};

namespace {

using Matrix = Eigen::SparseMatrix<double>;
using RowMatrix = Eigen::SparseMatrix<double, Eigen::RowMajor>;

constexpr double largest_condition = 1e12;

/// `map` of one column after the other. They are copied: the solvers take their operands for contiguous, which columns
/// of row-major values are not.
template <class Map> Values by_columns(const Values& x, const Map& map) {
    Values y;
    for (Eigen::Index c = 0; c < x.cols(); ++c) {
        const Eigen::VectorXd column = x.col(c);
        const Eigen::VectorXd image = map(column);
        y.resize(image.size(), x.cols());
        y.col(c) = image;
    }
    return y;
}

RowMatrix collocation(const Basis& basis, std::span<const SurfacePoint> points, const Execution& execution) {
    std::vector<BasisRow> rows(points.size());
    parallel_for(points.size(), 256, execution, [&](std::size_t begin, std::size_t end, unsigned) {
        for (std::size_t i = begin; i < end; ++i) {
            basis.evaluate(points[i], rows[i]);
        }
    });
    std::size_t entries = 0;
    for (const BasisRow& row : rows) {
        entries += row.element.size();
    }
    if (entries > static_cast<std::size_t>(std::numeric_limits<int>::max())) {
        throw ResourceError("the collocation matrix has more than 2^31 entries: give fewer --sites, --projection "
                            "natural, or a basis whose functions reach less far (--neighbours)");
    }
    RowMatrix Z(static_cast<Eigen::Index>(points.size()), static_cast<Eigen::Index>(basis.size()));
    Z.reserve(static_cast<Eigen::Index>(entries));
    std::vector<std::pair<Index, double>> sorted;
    for (std::size_t i = 0; i < rows.size(); ++i) {
        sorted.clear();
        for (std::size_t k = 0; k < rows[i].element.size(); ++k) {
            sorted.emplace_back(rows[i].element[k], rows[i].weight[k]);
        }
        std::sort(sorted.begin(), sorted.end());
        Z.startVec(static_cast<Eigen::Index>(i));
        for (const auto& [element, weight] : sorted) {
            Z.insertBack(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(element)) = weight;
        }
        rows[i] = {};
    }
    Z.finalize();
    return Z;
}

double norm_1(const Matrix& M) {
    double largest = 0.0;
    for (Eigen::Index column = 0; column < M.outerSize(); ++column) {
        largest = std::max(largest, M.col(column).cwiseAbs().sum());
    }
    return largest;
}

/// Hager's estimate of ‖M⁻¹‖₁ by a few solves with M and its transpose.
template <class Solve, class SolveTransposed>
double inverse_norm_1(const Solve& solve, const SolveTransposed& solve_transposed, Eigen::Index n) {
    Eigen::VectorXd x = Eigen::VectorXd::Constant(n, 1.0 / static_cast<double>(n));
    double estimate = 0.0;
    for (int step = 0; step < 5; ++step) {
        const Eigen::VectorXd y = solve(x);
        estimate = std::max(estimate, y.cwiseAbs().sum());
        const Eigen::VectorXd sign = y.unaryExpr([](double v) { return v < 0.0 ? -1.0 : 1.0; });
        const Eigen::VectorXd z = solve_transposed(sign);
        Eigen::Index j = 0;
        if (z.cwiseAbs().maxCoeff(&j) <= z.dot(x)) {
            break;
        }
        x = Eigen::VectorXd::Unit(n, j);
    }
    return estimate;
}

/// The share of each site's area that falls to each point, all points being dealt to their nearest site.
Eigen::VectorXd quadrature_weights(const SiteSet& sites, std::span<const SurfacePoint> points,
                                   const std::vector<double>& integrals) {
    const PointTree tree(sites.points);
    std::vector<std::size_t> owner(points.size()), members(sites.size(), 0);
    for (std::size_t q = 0; q < points.size(); ++q) {
        owner[q] = q < sites.size() ? q : tree.nearest(points[q].position);
        ++members[owner[q]];
    }
    // Elements of a basis that is no partition of unity may have no area of their own: then an average one.
    const double mean =
        std::accumulate(integrals.begin(), integrals.end(), 0.0) / static_cast<double>(integrals.size());
    Eigen::VectorXd weight(static_cast<Eigen::Index>(points.size()));
    for (std::size_t q = 0; q < points.size(); ++q) {
        weight[static_cast<Eigen::Index>(q)] =
            (integrals[owner[q]] > 1e-3 * mean ? integrals[owner[q]] : mean) / static_cast<double>(members[owner[q]]);
    }
    return weight;
}

void check_condition(double condition) {
    if (!(condition <= largest_condition)) {
        throw NotConverged("the elements of the basis overlap so much that their coefficients cannot be determined: "
                           "condition " +
                           text_of(condition) + ", at most " + text_of(largest_condition) +
                           " is usable. Give the basis a smaller width, or use a partition of unity "
                           "(--basis normalized-radial or shepard) with --projection natural or corrected");
    }
}

} // namespace

struct Projection::Map::Identity final : Map {
    Values apply(const Values& values, const Execution& /*execution*/) const override { return values; }
    Values transposed(const Values& coefficients) const override { return coefficients; }
    bool is_identity() const override { return true; }
    bool is_mean() const override { return true; }
    std::size_t entry_count() const override { return 0; }
};

/// P_ij = A_j / A_p for elements i and j of one patch p, of area A_p, else 0.
struct Projection::Map::PatchMeans final : Map {
    std::vector<std::size_t> first; ///< #patches with elements + 1
    std::vector<Index> member;      ///< elements, by patch, ascending
    std::vector<double> share;      ///< of each member in its patch
    explicit PatchMeans(const Substructure& of) : member(of.patch.size()) {
        std::iota(member.begin(), member.end(), Index{0});
        std::stable_sort(member.begin(), member.end(), [&](Index i, Index j) { return of.patch[i] < of.patch[j]; });
        for (std::size_t k = 0; k < member.size(); ++k) {
            if (k == 0 || of.patch[member[k]] != of.patch[member[k - 1]]) {
                first.push_back(k);
            }
            share.push_back(of.area[member[k]]);
        }
        first.push_back(member.size());
        for (std::size_t p = 0; p + 1 < first.size(); ++p) {
            double area = 0.0;
            for (std::size_t k = first[p]; k < first[p + 1]; ++k) {
                area += share[k];
            }
            for (std::size_t k = first[p]; k < first[p + 1]; ++k) {
                share[k] = first[p + 1] - first[p] == 1 ? 1.0 : share[k] / area;
            }
        }
    }
    Values apply(const Values& values, const Execution& execution) const override {
        Values means(values.rows(), values.cols());
        parallel_for(first.size() - 1, 1024, execution.silent(), [&](std::size_t begin, std::size_t end, unsigned) {
            Eigen::RowVectorXd mean(values.cols());
            for (std::size_t p = begin; p < end; ++p) {
                mean.setZero();
                for (std::size_t k = first[p]; k < first[p + 1]; ++k) {
                    mean += share[k] * values.row(static_cast<Eigen::Index>(member[k]));
                }
                for (std::size_t k = first[p]; k < first[p + 1]; ++k) {
                    means.row(static_cast<Eigen::Index>(member[k])) = mean;
                }
            }
        });
        return means;
    }
    Values transposed(const Values& coefficients) const override {
        Values image(coefficients.rows(), coefficients.cols());
        Eigen::RowVectorXd sum(coefficients.cols());
        for (std::size_t p = 0; p + 1 < first.size(); ++p) {
            sum.setZero();
            for (std::size_t k = first[p]; k < first[p + 1]; ++k) {
                sum += coefficients.row(static_cast<Eigen::Index>(member[k]));
            }
            for (std::size_t k = first[p]; k < first[p + 1]; ++k) {
                image.row(static_cast<Eigen::Index>(member[k])) = share[k] * sum;
            }
        }
        return image;
    }
    bool is_mean() const override { return true; }
    std::optional<SparseRows> matrix() const override {
        SparseRows rows(member.size(), member.size());
        for (std::size_t p = 0; p + 1 < first.size(); ++p) {
            for (std::size_t i = first[p]; i < first[p + 1]; ++i) {
                SparseRows::Row& row = rows.row(member[i]);
                for (std::size_t k = first[p]; k < first[p + 1]; ++k) {
                    row.column.push_back(member[k]);
                    row.value.push_back(share[k]);
                }
            }
        }
        return rows;
    }
    std::size_t entry_count() const override { return 2 * member.size(); }
};

/// P = Z⁻¹.
struct Projection::Map::Inverse final : Map {
    mutable Eigen::SparseLU<Matrix> lu; // its transpose() is not const
    double condition_number;
    explicit Inverse(const Matrix& Z) {
        lu.compute(Z);
        condition_number = std::numeric_limits<double>::infinity();
        if (lu.info() == Eigen::Success) {
            condition_number =
                norm_1(Z) * inverse_norm_1([&](const Eigen::VectorXd& y) { return solve(y); },
                                           [&](const Eigen::VectorXd& y) { return solve_transposed(y); }, Z.rows());
        }
        check_condition(condition_number);
    }
    Eigen::VectorXd solve(const Eigen::VectorXd& values) const { return lu.solve(values); }
    Eigen::VectorXd solve_transposed(const Eigen::VectorXd& x) const { return lu.transpose().solve(x); }
    Values apply(const Values& values, const Execution& /*execution*/) const override {
        return by_columns(values, [&](const Eigen::VectorXd& y) { return solve(y); });
    }
    Values transposed(const Values& coefficients) const override {
        return by_columns(coefficients, [&](const Eigen::VectorXd& x) { return solve_transposed(x); });
    }
    double condition() const override { return condition_number; }
    std::size_t entry_count() const override { return static_cast<std::size_t>(lu.nnzL() + lu.nnzU()); }
};

/// P = sum_{k=0..sweeps} (I - Z)^k, in Horner's form.
struct Projection::Map::Correction final : Map {
    RowMatrix Z;
    int sweeps;
    /// Takes the matrix over.
    Correction(RowMatrix& collocation, int count) : sweeps(count) { Z.swap(collocation); }
    Values apply(const Values& values, const Execution& execution) const override {
        Values b = values, next(values.rows(), values.cols());
        for (int k = 0; k < sweeps; ++k) {
            parallel_for(static_cast<std::size_t>(Z.rows()), 1024, execution.silent(),
                         [&](std::size_t begin, std::size_t end, unsigned) {
                             for (auto i = static_cast<Eigen::Index>(begin); i < static_cast<Eigen::Index>(end); ++i) {
                                 auto to = next.row(i);
                                 to.setZero();
                                 for (RowMatrix::InnerIterator entry(Z, i); entry; ++entry) {
                                     to += entry.value() * b.row(entry.col());
                                 }
                                 to = b.row(i) + (values.row(i) - to);
                             }
                         });
            b.swap(next);
        }
        return b;
    }
    void apply_single(const SingleValues& values, SingleValues& result, SingleValues& scratch,
                      const Execution& execution) const override {
        result.resize(values.rows(), values.cols());
        scratch.resize(sweeps > 1 ? values.rows() : 0, values.cols());
        const SingleValues* b = &values;
        for (int k = 0; k < sweeps; ++k) {
            SingleValues& next = (sweeps - k) % 2 == 1 ? result : scratch; // the last sweep is into the result
            sweep(*b, values, next, execution);
            b = &next;
        }
        if (sweeps == 0) {
            result = values;
        }
    }
    Values transposed(const Values& coefficients) const override {
        Values w = coefficients;
        for (int k = 0; k < sweeps; ++k) {
            w += coefficients - Z.transpose() * w;
        }
        return w;
    }
    /// next = b + values - Z b, with sums of double precision.
    void sweep(const SingleValues& b, const SingleValues& values, SingleValues& next,
               const Execution& execution) const {
        const Eigen::Index width = values.cols();
        parallel_for(static_cast<std::size_t>(Z.rows()), 256, execution.silent(),
                     [&](std::size_t begin, std::size_t end, unsigned) {
                         with_wide_vectors([&] {
                             for (auto i = static_cast<Eigen::Index>(begin); i < static_cast<Eigen::Index>(end); ++i) {
                                 for_panels<96, 24, 21, 8, 7, 3, 1>(width, [&](auto count, Eigen::Index c) {
                                     sweep_columns<count>(i, b.data() + c, values.row(i).data() + c, width,
                                                          next.row(i).data() + c);
                                 });
                             }
                         });
                     });
    }
    /// `count` columns of row i.
    template <int count>
    void sweep_columns(Eigen::Index i, const float* b, const float* values, Eigen::Index width, float* to) const {
        double sum[count];
        for (int c = 0; c < count; ++c) {
            sum[c] = static_cast<double>(b[i * width + c]) + static_cast<double>(values[c]);
        }
        for (RowMatrix::InnerIterator entry(Z, i); entry; ++entry) {
            one_term_at_a_time();
            const double weight = entry.value();
            const float* const source = b + entry.col() * width;
            for (int c = 0; c < count; ++c) {
                sum[c] -= weight * static_cast<double>(source[c]);
            }
        }
        for (int c = 0; c < count; ++c) {
            to[c] = static_cast<float>(sum[c]);
        }
    }
    std::optional<SparseRows> matrix() const override {
        RowMatrix one(Z.rows(), Z.cols());
        one.setIdentity();
        const RowMatrix missed = one - Z;
        RowMatrix sum = one;
        for (int k = 0; k < sweeps; ++k) {
            sum = RowMatrix(one + RowMatrix(missed * sum));
        }
        SparseRows rows(static_cast<std::size_t>(sum.rows()), static_cast<std::size_t>(sum.cols()));
        for (Eigen::Index i = 0; i < sum.rows(); ++i) {
            SparseRows::Row& row = rows.row(static_cast<std::size_t>(i));
            for (RowMatrix::InnerIterator entry(sum, i); entry; ++entry) {
                row.column.push_back(static_cast<Index>(entry.col()));
                row.value.push_back(entry.value());
            }
        }
        return rows;
    }
    std::size_t entry_count() const override {
        return static_cast<std::size_t>(sweeps) * static_cast<std::size_t>(Z.nonZeros());
    }
};

/// P = (ZᵀWZ)⁻¹ ZᵀW.
struct Projection::Map::LeastSquares final : Map {
    Matrix ZtW;
    Eigen::SimplicialLDLT<Matrix> factor;
    double condition_number;
    LeastSquares(const Matrix& Z, const Eigen::VectorXd& W) : ZtW(Z.transpose() * W.asDiagonal()) {
        const Matrix M = ZtW * Z;
        factor.compute(M);
        condition_number = std::numeric_limits<double>::infinity();
        if (factor.info() == Eigen::Success && (factor.vectorD().array() > 0.0).all()) {
            const auto solve = [&](const Eigen::VectorXd& y) { return Eigen::VectorXd(factor.solve(y)); };
            condition_number = norm_1(M) * inverse_norm_1(solve, solve, M.rows());
        }
        check_condition(condition_number);
    }
    Values apply(const Values& values, const Execution& /*execution*/) const override {
        return by_columns(values, [&](const Eigen::VectorXd& y) {
            const Eigen::VectorXd moments = ZtW * y;
            return Eigen::VectorXd(factor.solve(moments));
        });
    }
    Values transposed(const Values& coefficients) const override {
        return by_columns(coefficients, [&](const Eigen::VectorXd& x) {
            return Eigen::VectorXd(ZtW.transpose() * Eigen::VectorXd(factor.solve(x)));
        });
    }
    double condition() const override { return condition_number; }
    std::size_t entry_count() const override {
        return static_cast<std::size_t>(ZtW.nonZeros() + 2 * factor.matrixL().nestedExpression().nonZeros());
    }
};

ProjectionChoice parse_projection(std::string_view choice, std::string& text) {
    const ParameterSpec sweeps{"sweeps", ParameterSpec::Type::integer, "2", "times the residual is put back", 1, 16,
                               {}};
    const ParameterSpec where{"in",
                              ParameterSpec::Type::word,
                              "field",
                              "what has these coefficients: the field that is evaluated, or the equation as well",
                              0,
                              0,
                              {"field", "equation"}};
    const ParameterSpec points{
        "points", ParameterSpec::Type::real, "3", "points for each element at which light is gathered", 1.0, 64.0, {}};
    const Choice parsed = parse_choice("projection", choice,
                                       {{"natural", {}},
                                        {"substructured", {}},
                                        {"interpolation", {}},
                                        {"corrected", {sweeps, where}},
                                        {"least-squares", {points}},
                                        {"galerkin", {points}}});
    text = parsed.text();
    ProjectionChoice result;
    if (parsed.name == "substructured") {
        result.kind = ProjectionKind::substructured;
    } else if (parsed.name == "interpolation") {
        result.kind = ProjectionKind::interpolation;
    } else if (parsed.name == "corrected") {
        result.kind = ProjectionKind::corrected;
        result.sweeps = static_cast<int>(parsed.parameters.integer("sweeps"));
        result.in_equation = parsed.parameters.word("in") == "equation";
    } else if (parsed.name != "natural") {
        result.kind = parsed.name == "galerkin" ? ProjectionKind::galerkin : ProjectionKind::least_squares;
        result.points = parsed.parameters.real("points");
    }
    return result;
}

ProjectionChoice projection_for(const Basis& basis, std::string_view choice, std::string& text, bool subdivided) {
    const bool smooths = basis.coefficients_are_values() && !basis.interpolates();
    // A partition of unity is sure to converge with its own coefficients: that is worth more than accuracy.
    const ProjectionChoice result = parse_projection(!choice.empty()              ? choice
                                                     : subdivided                 ? "substructured"
                                                     : !smooths                   ? "natural"
                                                     : basis.partition_of_unity() ? "corrected"
                                                                                  : "corrected:in=equation",
                                                     text);
    if (result.kind == ProjectionKind::substructured && !subdivided) {
        throw UsageError("--projection substructured: is for elements that are parts of patches, and none is divided "
                         "here; add --adaptive to --basis patch-constant, or use another projection");
    }
    if (result.kind == ProjectionKind::corrected) {
        if (basis.interpolates()) {
            throw UsageError(
                "--projection corrected: this basis interpolates, so there is no residual to put back; use "
                "--projection natural");
        }
        if (!smooths && !result.in_equation) {
            throw UsageError("--projection corrected: the coefficients of this basis are solved for, so there is no "
                             "residual to put back into the field; use --projection natural, or corrected:in=equation "
                             "to solve for them by that iteration");
        }
    }
    return result;
}

bool is_local(const ProjectionChoice& choice, const Basis& basis) {
    return choice.kind == ProjectionKind::corrected || choice.kind == ProjectionKind::substructured ||
           (choice.kind == ProjectionKind::natural && basis.coefficients_are_values());
}

std::vector<SurfacePoint> projection_points(const ProjectionChoice& choice, const Mesh& mesh, const SiteSet& sites,
                                            std::uint64_t seed) {
    std::vector<SurfacePoint> points = sites.points;
    if (choice.kind == ProjectionKind::least_squares || choice.kind == ProjectionKind::galerkin) {
        const auto more = static_cast<std::size_t>((choice.points - 1.0) * static_cast<double>(sites.size()));
        const std::vector<SurfacePoint> further = even_points(mesh, more, RandomStream(seed, "projection points"));
        points.insert(points.end(), further.begin(), further.end());
    }
    return points;
}

Projection::Projection(const Basis& basis, const SiteSet& sites, const ProjectionChoice& choice,
                       std::span<const SurfacePoint> points, const std::vector<double>& integrals,
                       const Execution& execution) {
    ProjectionKind kind = choice.kind;
    if (kind == ProjectionKind::natural) {
        if (basis.coefficients_are_values()) {
            map_ = std::make_unique<Map::Identity>();
            return;
        }
        kind = ProjectionKind::interpolation;
    }
    if (kind == ProjectionKind::substructured) {
        const Substructure* const substructure = basis.substructure();
        DIFUSA_REQUIRE(substructure != nullptr);
        map_ = std::make_unique<Map::PatchMeans>(*substructure);
        return;
    }
    RowMatrix Z = collocation(basis, points, execution);
    if (kind == ProjectionKind::interpolation) {
        map_ = std::make_unique<Map::Inverse>(Z);
    } else if (kind == ProjectionKind::corrected) {
        map_ = std::make_unique<Map::Correction>(Z, choice.sweeps);
    } else {
        const Eigen::VectorXd W = kind == ProjectionKind::galerkin ? quadrature_weights(sites, points, integrals)
                                                                   : Eigen::VectorXd::Ones(Z.rows());
        map_ = std::make_unique<Map::LeastSquares>(Z, W);
    }
    condition_ = map_->condition();
}

Projection::~Projection() = default;
Projection::Projection(Projection&&) noexcept = default;
Projection& Projection::operator=(Projection&&) noexcept = default;

bool Projection::is_identity() const {
    return map_->is_identity();
}

bool Projection::is_mean() const {
    return map_->is_mean();
}

Values Projection::coefficients(const Values& values, const Execution& execution) const {
    return map_->apply(values, execution);
}

void Projection::coefficients(const SingleValues& values, SingleValues& result, SingleValues& scratch,
                              const Execution& execution) const {
    map_->apply_single(values, result, scratch, execution);
}

Values Projection::transposed(const Values& x) const {
    return map_->transposed(x);
}

std::optional<SparseRows> Projection::matrix() const {
    return map_->matrix();
}

std::size_t Projection::entry_count() const {
    return map_->entry_count();
}

Values limited(const Basis& basis, const SiteSet& sites, const Values& values, Values coefficients,
               const Execution& execution, bool any_sign) {
    parallel_for(sites.size(), 64, execution, [&](std::size_t begin, std::size_t end, unsigned) {
        BasisRow row;
        for (std::size_t j = begin; j < end; ++j) {
            basis.evaluate(sites.points[j], row);
            Eigen::RowVectorXd least = values.row(static_cast<Eigen::Index>(j)), most = least;
            for (const Index i : row.element) {
                least = least.cwiseMin(values.row(i));
                most = most.cwiseMax(values.row(i));
            }
            auto own = coefficients.row(static_cast<Eigen::Index>(j));
            const Eigen::RowVectorXd more = 0.25 * (most - least);
            least = any_sign ? Eigen::RowVectorXd(least - more) : (least - more).cwiseMax(least.cwiseMin(0.0)).eval();
            own = own.cwiseMax(least).cwiseMin(most + more).eval();
        }
    });
    return coefficients;
}

Values sum_of_parts(const Values& values, int channels) {
    Values sum = Values::Zero(values.rows(), channels);
    for (Eigen::Index c = 0; c < values.cols(); c += channels) {
        sum += values.middleCols(c, channels);
    }
    return sum;
}

Values limited_parts(const Basis& basis, const SiteSet& sites, const Values& values, Values coefficients, int channels,
                     const Execution& execution, bool any_sign) {
    if (values.cols() == channels) {
        return limited(basis, sites, values, std::move(coefficients), execution, any_sign);
    }
    const Values sum = sum_of_parts(values, channels), own = sum_of_parts(coefficients, channels);
    const Values change = limited(basis, sites, sum, own, execution, any_sign) - own;
    for (Eigen::Index i = 0; i < values.rows(); ++i) {
        for (Eigen::Index c = 0; c < values.cols(); ++c) {
            const Eigen::Index channel = c % channels;
            if (change(i, channel) != 0.0 && sum(i, channel) != 0.0) {
                coefficients(i, c) += change(i, channel) * (values(i, c) / sum(i, channel));
            } else if (change(i, channel) != 0.0) {
                coefficients(i, c) += change(i, channel) * channels / static_cast<double>(values.cols());
            }
        }
    }
    return coefficients;
}

} // namespace difusa
