// Marks on a picture: text, discs, and the colour bar. Points as in CameraRays; colours are linear.
#pragma once

#include <difusa/core/types.h>
#include <difusa/render/colour_map.h>
#include <difusa/scene/image.h>

#include <string>

namespace difusa {

/// Letters of 5 by 7 squares of `size` pixels, six squares apart; the upper left corner of the first is at (column,
/// row), which may be outside the picture. Supported are letters (capitals look like small ones, except W), digits and
/// . , : + - / ^ ( ) % = _; anything else is a blank.
void draw_text(Image& image, const std::string& text, std::ptrdiff_t column, std::ptrdiff_t row, std::size_t size,
               const Rgb& colour);

/// Partly covered pixels are blended with the colour.
void draw_disc(Image& image, double column, double row, double radius, const Rgb& colour);

/// "0.0123", "43600", "4.36e+06": three digits, and a power of ten only where the zeros would have to be counted.
std::string bar_label(double value);

/// The picture with a panel to the right of it: the title ("name, unit") and a bar, labelled with the values at its
/// ends and at round values between them. The width of the panel depends on the height of the picture and on the texts.
Image with_colour_bar(const Image& image, const ColourScale& scale, const std::string& title);

} // namespace difusa
