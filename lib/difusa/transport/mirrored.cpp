#include <difusa/transport/mirrored.h>

namespace difusa {

void MirroredTransport::apply(const Values& x, Values& y, const Execution& execution) const {
    Values reflected;
    plain_->apply(x, y, execution);
    in_mirrors_->apply(x, reflected, execution);
    y += reflected;
}

void MirroredTransport::apply_transpose(const Values& x, Values& y, const Execution& execution) const {
    Values reflected;
    plain_->apply_transpose(x, y, execution);
    in_mirrors_->apply_transpose(x, reflected, execution);
    y += reflected;
}

namespace {

/// W without what glossy surfaces reflect.
const LinearOperator& without_gloss(const LinearOperator& W) {
    const auto* const glossy = dynamic_cast<const GlossyAddition*>(&W);
    return glossy == nullptr ? W : glossy->matt();
}

} // namespace

const LinearOperator& plain_part(const LinearOperator& W) {
    const LinearOperator& matt = without_gloss(W);
    const auto* const mirrored = dynamic_cast<const MirroredTransport*>(&matt);
    const LinearOperator& plain = mirrored == nullptr ? matt : *mirrored->plain();
    const auto* const refined = dynamic_cast<const RefinedTransport*>(&plain);
    return refined == nullptr ? plain : refined->by_rays();
}

const RefinedTransport* refined_part(const LinearOperator& W) {
    return dynamic_cast<const RefinedTransport*>(&without_gloss(W));
}

std::shared_ptr<const ChannelRows> part_in_mirrors(const LinearOperator& W) {
    const auto* const mirrored = dynamic_cast<const MirroredTransport*>(&without_gloss(W));
    return mirrored == nullptr ? nullptr : mirrored->in_mirrors();
}

bool tells_channels_apart(const LinearOperator& W) {
    const std::shared_ptr<const ChannelRows> in_mirrors = part_in_mirrors(W);
    const auto* const glossy = dynamic_cast<const GlossyAddition*>(&W);
    return (in_mirrors && in_mirrors->channels() > 1) || (glossy != nullptr && glossy->channels() > 1);
}

} // namespace difusa
