#include <difusa/radiosity/rendering_operator.h>

#include <difusa/algebra/dense.h>
#include <difusa/core/memory.h>
#include <difusa/core/parallel.h>
#include <difusa/plugin/choice.h>
#include <difusa/radiosity/reflected_transport.h>
#include <difusa/radiosity/response.h>
#include <difusa/transport/mirrored.h>

#include <algorithm>
#include <limits>
#include <utility>

namespace difusa {

namespace {

constexpr Eigen::Index rows_at_once = 512; ///< of a product; fixed, so that sums do not depend on threads

template <class Body> void for_rows(Eigen::Index rows, const Execution& execution, const Body& body) {
    const auto blocks = static_cast<std::size_t>((rows + rows_at_once - 1) / rows_at_once);
    parallel_for(blocks, 1, execution.silent(), [&](std::size_t begin, std::size_t end, unsigned) {
        for (std::size_t block = begin; block < end; ++block) {
            const Eigen::Index first = static_cast<Eigen::Index>(block) * rows_at_once;
            body(first, std::min(rows_at_once, rows - first), block);
        }
    });
}

/// y += A g
void add_product(const Values& A, const Values& g, Values& y, const Execution& execution) {
    for_rows(A.rows(), execution, [&](Eigen::Index first, Eigen::Index count, std::size_t) {
        y.middleRows(first, count).noalias() += A.middleRows(first, count) * g;
    });
}

/// Aᵀ g, the sum over blocks of rows in order.
Values transposed_product(const Values& A, const Values& g, const Execution& execution) {
    std::vector<Values> sums(static_cast<std::size_t>((A.rows() + rows_at_once - 1) / rows_at_once));
    for_rows(A.rows(), execution, [&](Eigen::Index first, Eigen::Index count, std::size_t block) {
        sums[block].noalias() = A.middleRows(first, count).transpose() * g.middleRows(first, count);
    });
    Values y = Values::Zero(A.cols(), g.cols());
    for (const Values& sum : sums) {
        y += sum;
    }
    return y;
}

/// The first channel alone if the others are the same.
Values distinct(const Values& reflectance, const LightTransport& transport) {
    for (Eigen::Index c = 1; c < reflectance.cols(); ++c) {
        if (reflectance.col(c) != reflectance.col(0)) {
            return reflectance;
        }
    }
    return tells_channels_apart(*transport.W) ? reflectance : Values(reflectance.leftCols(1));
}

/// rho P Π g: the radiosity that an irradiance of the points makes.
Values radiosity_by(const Discretisation& discretisation, const Values& reflectance, const Values& g,
                    const Execution& execution) {
    Values b;
    const Projection& projection = *discretisation.projection;
    discretisation.averages->reflect(projection.is_identity() ? g : projection.coefficients(g, execution), reflectance,
                                     discretisation.averages->rows(), b, execution);
    return b;
}

} // namespace

OperatorChoice parse_operator(std::string_view text) {
    using Type = ParameterSpec::Type;
    constexpr double most = 1e6;
    const std::vector<ChoiceSpec> known = {
        {"neumann", {{"bounces", Type::integer, "8", "reflections", 0, most, {}}}},
        {"dense", {}},
        {"low-rank",
         {{"rank", Type::integer, "64", "rank for each channel", 1, most, {}},
          {"bounces", Type::integer, "1", "reflections that are products with T", 0, most, {}},
          {"more", Type::integer, "16", "directions explored beyond the rank", 2, most, {}}}}};
    const Choice chosen = parse_choice("operator", text, known);
    OperatorChoice choice;
    choice.text = chosen.text();
    if (chosen.name == "dense") {
        choice.kind = OperatorChoice::Kind::dense;
        choice.bounces = 0;
        return choice;
    }
    choice.bounces = static_cast<int>(chosen.parameters.integer("bounces"));
    if (chosen.name == "low-rank") {
        choice.kind = OperatorChoice::Kind::low_rank;
        choice.low_rank.rank = static_cast<std::size_t>(chosen.parameters.integer("rank"));
        choice.low_rank.more = static_cast<std::size_t>(chosen.parameters.integer("more"));
    }
    return choice;
}

RenderingOperator::RenderingOperator(std::shared_ptr<const RadiositySystem> system, const Values& reflectance,
                                     const OperatorChoice& choice, double radius, const SolveOptions& solve,
                                     const Execution& execution)
    : system_(std::move(system)), choice_(choice), radius_(radius), channels_(reflectance.cols()),
      reflectance_(distinct(reflectance, system_->transport())) {
    DIFUSA_REQUIRE(reflectance.rows() == static_cast<Eigen::Index>(system_->transport().surfels));
    if (!(radius >= 0.0 && radius < 1.0)) {
        throw UsageError("the spectral radius must be at least 0 and below 1");
    }
    if (choice.kind == OperatorChoice::Kind::dense) {
        make_dense(execution);
    } else if (choice.kind == OperatorChoice::Kind::low_rank) {
        make_low_rank(choice, solve, execution);
    }
}

void RenderingOperator::make_dense(const Execution& execution) {
    const auto n = static_cast<Eigen::Index>(system_->transport().points()), channels = reflectance_.cols();
    constexpr double matrices = 3.0; // the decomposition and its inverse beside T
    require_memory(
        (static_cast<double>(channels) + matrices) * sizeof(double) * static_cast<double>(n) * static_cast<double>(n),
        execution.memory_left(), "the rendering operator as a matrix", "choose low-rank, or give fewer --sites");
    const ReflectedTransport T(system_->discretisation(), system_->transport(), reflectance_);
    std::vector<Eigen::MatrixXd> A(static_cast<std::size_t>(channels), Eigen::MatrixXd::Identity(n, n));
    const Eigen::Index block = columns_at_once(system_->transport()) / channels;
    for (Eigen::Index first = 0; first < n; first += block) {
        execution.check();
        const Eigen::Index count = std::min(block, n - first);
        Values unit = Values::Zero(n, count * channels), column;
        for (Eigen::Index k = 0; k < count; ++k) {
            unit.row(first + k).segment(k * channels, channels).setOnes();
        }
        T.apply(unit, column, execution.silent());
        for (Eigen::Index k = 0; k < count * channels; ++k) {
            A[static_cast<std::size_t>(k % channels)].col(first + k / channels) -= column.col(k);
        }
    }
    for (Eigen::MatrixXd& each : A) {
        execution.check();
        Inverse inverse = dense_inverse(std::move(each));
        const double precision = std::numeric_limits<double>::epsilon();
        if (!(inverse.rcond > precision)) {
            throw NotConverged("the bounces of light do not die out: I - T is singular to working precision; use "
                               "--basis normalized-radial");
        }
        parts_.push_back({inverse.matrix, {}, {}, precision / inverse.rcond});
    }
}

void RenderingOperator::make_low_rank(const OperatorChoice& choice, const SolveOptions& solve,
                                      const Execution& execution) {
    LowRankOptions options = choice.low_rank;
    options.bounces = choice.bounces;
    options.solve = solve;
    std::vector<LowRankLight> light = low_rank_light(*system_, reflectance_, options, execution);
    const Discretisation& discretisation = system_->discretisation();
    for (std::size_t c = 0; c < light.size(); ++c) {
        Values& V = light[c].V; // of rho P Π g, and afterwards of g
        V.array().colwise() *= reflectance_.col(static_cast<Eigen::Index>(c)).array();
        Values coefficients;
        discretisation.averages->apply_transpose(V, coefficients, execution);
        parts_.push_back(
            {{}, std::move(light[c].U), discretisation.projection->transposed(coefficients), light[c].error});
        V.resize(0, 0);
    }
}

void RenderingOperator::add_products(const Values& g, Values& h, const Execution& execution) const {
    const auto multiply = [&](const Part& part, const Values& from, Values& to) {
        if (part.M.size() > 0) {
            add_product(part.M, from, to, execution);
        } else {
            add_product(part.U, transposed_product(part.V, from, execution), to, execution);
        }
    };
    if (parts_.size() == 1) {
        multiply(parts_.front(), g, h);
        return;
    }
    const auto channels = static_cast<Eigen::Index>(parts_.size());
    for (Eigen::Index c = 0; c < channels; ++c) {
        const auto own = Eigen::seq(c, g.cols() - 1, channels);
        Values to = h(Eigen::all, own);
        multiply(parts_[static_cast<std::size_t>(c)], g(Eigen::all, own), to);
        h(Eigen::all, own) = to;
    }
}

Values RenderingOperator::applied(const Values& g, std::vector<double>* error, const Execution& execution) const {
    DIFUSA_REQUIRE(g.rows() == static_cast<Eigen::Index>(system_->transport().points()) && g.cols() % channels_ == 0);
    const bool dense = choice_.kind == OperatorChoice::Kind::dense;
    const ReflectedTransport T(system_->discretisation(), system_->transport(), reflectance_);
    Values h = dense ? Values(Values::Zero(g.rows(), g.cols())) : g, last = g, next;
    for (int k = 0; k < choice_.bounces; ++k) {
        execution.check();
        T.apply(last, next, execution.silent());
        h += next;
        last.swap(next);
    }
    if (!parts_.empty()) {
        add_products(g, h, execution);
    }
    if (error == nullptr) {
        return h;
    }
    const AreaNorms norms(system_->discretisation());
    if (parts_.empty()) {
        *error = norms.of_points(last);
    } else if (dense) {
        *error = norms.of_points(h);
    } else {
        *error = norms.of_surfels(radiosity_by(system_->discretisation(), reflectance_, g, execution));
    }
    for (std::size_t c = 0; c < error->size(); ++c) {
        (*error)[c] *= parts_.empty() ? radius_ / (1.0 - radius_) : parts_[c % parts_.size()].error;
    }
    return h;
}

std::size_t RenderingOperator::bytes() const {
    std::size_t bytes = 0;
    for (const Part& part : parts_) {
        bytes += sizeof(double) * static_cast<std::size_t>(part.M.size() + part.U.size() + part.V.size());
    }
    return bytes;
}

} // namespace difusa
