// The unit disc, and with it the hemisphere above, divided into rings and these into sectors.
#pragma once

#include <difusa/rays/directions.h>

#include <cstddef>
#include <span>

namespace difusa {

/// One direction through each cell of a division of the unit disc, lifted to the hemisphere (the Nusselt analogue, L
/// 38): the weight of a cell is its share of the disc. Ring k reaches from the share border[k] of the disc's area to
/// border[k + 1], with border[0] = 0 and the last border 1, and has sectors[k] equal sectors.
///
/// Without `stream` directions pass through the middles of the cells by area and angle; with it through a random point
/// of each, uniform by area: means over such sets have no error.
DirectionSet through_ring_cells(std::span<const double> border, std::span<const std::size_t> sectors,
                                RandomStream* stream);

} // namespace difusa
