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

const LinearOperator& plain_part(const LinearOperator& W) {
    const auto* const mirrored = dynamic_cast<const MirroredTransport*>(&W);
    return mirrored == nullptr ? W : *mirrored->plain();
}

std::shared_ptr<const ChannelRows> part_in_mirrors(const LinearOperator& W) {
    const auto* const mirrored = dynamic_cast<const MirroredTransport*>(&W);
    return mirrored == nullptr ? nullptr : mirrored->in_mirrors();
}

} // namespace difusa
