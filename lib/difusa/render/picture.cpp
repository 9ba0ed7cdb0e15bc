#include <difusa/render/picture.h>

#include <difusa/core/memory.h>
#include <difusa/core/parallel.h>
#include <difusa/core/photometry.h>
#include <difusa/core/random.h>
#include <difusa/core/text.h>
#include <difusa/plugin/parameters.h>
#include <difusa/radiosity/error_map.h>
#include <difusa/render/camera_rays.h>
#include <difusa/render/draw.h>
#include <difusa/render/specular_paths.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <span>
#include <utility>

namespace difusa {

namespace {

using Pixel = std::array<float, 3>;

constexpr std::size_t batch_samples = 65536; ///< about as many at a time as fit into the caches with all their values
constexpr double dot_radius = 2.0;           ///< pixels
const Rgb dark_grey = Rgb::Constant(0.02), dot_colour{0.02, 0.05, 0.35};
/// Between the lights and the darks of most pictures; lighter around false colours and sites, whose ends are dark.
const Rgb neutral = Rgb::Constant(0.18), light_neutral = Rgb::Constant(0.6);

Pixel pixel_of(const Rgb& c) {
    DIFUSA_REQUIRE(c.allFinite(), text_of(c));
    return {static_cast<float>(c[0]), static_cast<float>(c[1]), static_cast<float>(c[2])};
}

bool shows_error(const Show& show) {
    return show.quantity == Quantity::error || show.quantity == Quantity::illuminance_error;
}

double thermal_value(Quantity quantity, const ThermalState& state) {
    switch (quantity) {
    case Quantity::temperature:
        return state.temperature;
    case Quantity::net_flux:
        return state.net_flux;
    case Quantity::irradiance_weighted:
        return state.irradiation;
    default:
        return state.radiosity;
    }
}

void add_to(Pixel& pixel, const Rgb& c) {
    const Pixel more = pixel_of(c);
    for (std::size_t k = 0; k < 3; ++k) {
        pixel[k] += more[k];
    }
}

/// Maps the progress of part of a phase to that of the phase.
class PartOfPhase final : public SubordinateProgress {
  public:
    using SubordinateProgress::SubordinateProgress;

    void set(double begin, double share) {
        begin_ = begin;
        share_ = share;
    }
    void advance(double fraction) override {
        if (whole() != nullptr) {
            whole()->advance(begin_ + share_ * fraction);
        }
    }

  private:
    double begin_ = 0.0, share_ = 1.0;
};

/// Computes the samples of a view in batches.
class Look {
  public:
    Look(const BakeResult& result, const Execution& execution, View& view)
        : result_(result), scene_(*result.scene), basis_(*result.system->discretisation().basis),
          parts_(result.field().parts()), view_(view),
          camera_(view.options.camera, view.options.width, view.options.height), progress_(execution.progress),
          execution_(execution.with(&progress_, nullptr)) {
        lit_ = std::any_of(view.shows.begin(), view.shows.end(), [](const Show& show) {
            return show.quantity != Quantity::basis && show.quantity != Quantity::sites &&
                   show.quantity != Quantity::reflectance && show.quantity != Quantity::emission;
        });
        if (std::any_of(view.shows.begin(), view.shows.end(), shows_error)) {
            errors_.emplace(result.solution, *result.error, execution_);
        }
        // The shadow rays to area lights of all samples of a pixel add up.
        parts_.shadow_rays = std::max<std::size_t>(8, parts_.shadow_rays / view.options.samples);
    }

    void take() {
        const std::size_t per_pixel = view_.options.samples;
        const std::size_t pixels = view_.options.width * view_.options.height;
        const std::size_t step = std::max<std::size_t>(1, batch_samples / per_pixel);
        for (std::size_t first = 0; first < pixels; first += step) {
            const std::size_t end = std::min(first + step, pixels);
            const auto done = [&](double pixel) { return pixel / static_cast<double>(pixels); };
            const double begin = done(static_cast<double>(first)), share = done(static_cast<double>(end - first));
            progress_.set(begin, 0.1 * share);
            view_.seen.resize(end * per_pixel);
            for (std::vector<Pixel>& values : view_.values) {
                values.resize(end * per_pixel);
            }
            cast(first, end);
            progress_.set(begin + 0.1 * share, 0.9 * share);
            evaluate(first / step);
        }
    }

  private:
    /// Casts the rays of pixels `first` to `end`.
    void cast(std::size_t first, std::size_t end) {
        const ViewOptions& options = view_.options;
        const std::size_t per_pixel = options.samples, offset = first * per_pixel;
        const auto grid = static_cast<std::size_t>(std::lround(std::sqrt(static_cast<double>(per_pixel))));
        batch_.resize((end - first) * per_pixel);
        directions_.resize(batch_.size());
        const bool specular = scene_.mesh.mirrors.any() || scene_.mesh.glossy.any();
        in_mirrors_.assign(specular ? batch_.size() : 0, {});
        glossy_.assign(in_mirrors_.size(), {});
        const SpecularPaths paths(scene_.mesh, result_.system->tracer().engine(), options.glossy_rays);
        parallel_for(end - first, 256, execution_, [&](std::size_t begin, std::size_t stop, unsigned) {
            for (std::size_t pixel = first + begin; pixel < first + stop; ++pixel) {
                RandomStream stream(options.seed, "picture", pixel);
                const std::size_t right = pixel % options.width, down = pixel / options.width;
                const auto column = static_cast<double>(right), row = static_cast<double>(down);
                std::size_t sample = (pixel - first) * per_pixel;
                for (const auto& [x, y] : jittered_places(grid, stream)) {
                    const Vec3 direction = camera_.direction(column + x, row + y);
                    const Visibility& engine = result_.system->tracer().engine();
                    const Ray ray{camera_.eye(), direction, none};
                    const Hit hit = first_shown(scene_.mesh, engine, ray, options.cull_backs);
                    if (specular) {
                        paths.follow(hit, direction, stream, in_mirrors_[sample], glossy_[sample]);
                    }
                    directions_[sample] = direction;
                    CameraHit& seen = view_.seen[offset + sample];
                    seen = hit.face == none ? CameraHit::nothing : hit.front ? CameraHit::surface : CameraHit::back;
                    SurfacePoint& point = batch_[sample];
                    if (seen == CameraHit::surface) {
                        point = scene_.mesh.shaded(scene_.mesh.at(hit.face, hit.u, hit.v));
                        const bool lamp = !scene_.thermal && (scene_.emission(point) > 0.0).any();
                        seen = lamp ? CameraHit::lamp : CameraHit::surface;
                    }
                    ++sample;
                }
            }
        });
        points_.clear();
        numbers_.clear();
        for (std::size_t i = 0; i < batch_.size(); ++i) {
            if (const CameraHit seen = view_.seen[offset + i]; seen == CameraHit::surface || seen == CameraHit::lamp) {
                points_.push_back(batch_[i]);
                numbers_.push_back(i);
            }
        }
        colours_.assign(points_.size(), Rgb::Ones());
        seen_directly_ = points_.size();
        for (std::size_t i = 0; i < in_mirrors_.size(); ++i) {
            for (const SeenInMirror& sight : in_mirrors_[i]) {
                if (sight.hit.face != none && sight.hit.front) {
                    points_.push_back(scene_.mesh.shaded(scene_.mesh.at(sight.hit.face, sight.hit.u, sight.hit.v)));
                    numbers_.push_back(i);
                    colours_.push_back(sight.colour);
                }
            }
        }
        offset_ = offset;
    }

    /// Values at the hits of the batch's rays.
    void evaluate(std::size_t batch) {
        PointValues light;
        if (lit_ && !points_.empty()) {
            light = Field(parts_).at(points_, view_.options.final_gather, result_.options.seed,
                                     "picture " + std::to_string(batch), execution_);
            view_.rays += light.rays;
            view_.segments += light.segments;
        }
        for (std::size_t k = 0; k < view_.shows.size(); ++k) {
            const Show& show = view_.shows[k];
            std::vector<Pixel>& values = view_.values[k];
            if (show.quantity == Quantity::basis) {
                add_basis(show, values);
            } else if (shows_error(show)) {
                add_error(light, show, values);
            } else {
                for (std::size_t p = 0; p < seen_directly_; ++p) {
                    values[offset_ + numbers_[p]] = pixel_of(value_of(show, light, p));
                }
                for (std::size_t p = seen_directly_; p < points_.size() && shows_in_mirrors(show.quantity); ++p) {
                    add_to(values[offset_ + numbers_[p]], value_of(show, light, p));
                }
            }
            if (shows_sky(show.quantity)) {
                add_sky(show, values);
            }
        }
        if (scene_.mesh.glossy.any() && parts_.direct->any()) {
            add_highlights(batch);
        }
    }

    /// The light of suns and point lights that glossy surfaces reflect. That of lamps is seen as they are met.
    void add_highlights(std::size_t batch) {
        parallel_for(glossy_.size(), 256, execution_, [&](std::size_t begin, std::size_t end, unsigned) {
            std::vector<SurfacePoint> at;
            std::vector<DirectLight::Arrival> arrivals;
            DirectLight::Worker worker;
            for (std::size_t i = begin; i < end; ++i) {
                at.clear();
                for (const SeenGloss& each : glossy_[i]) {
                    at.push_back(each.at);
                }
                RandomStream stream(view_.options.seed, "highlights", batch * batch_samples + i);
                parts_.direct->sample_directions(at, stream, arrivals, worker);
                for (const DirectLight::Arrival& arrival : arrivals) {
                    const SeenGloss& gloss = glossy_[i][arrival.place];
                    if (arrival.from_outside) {
                        const GlossyLobe& lobe = scene_.mesh.glossy.lobe_of(gloss.kind);
                        const double f = std::numbers::pi *
                                         lobe.value(gloss.at.normal, arrival.towards, -gloss.direction.normalized());
                        add_highlight(i, arrival.set, gloss.colour * f * arrival.H);
                    }
                }
            }
        });
    }

    /// What a picture shows of light from outside the surface, given as π times its radiance, of a set of lights.
    Rgb shown_of(const Show& show, Index set, const Rgb& light) const {
        switch (show.quantity) {
        case Quantity::radiosity:
        case Quantity::direct:
            return light;
        case Quantity::group:
            return parts_.direct->sets().names[set] == show.group ? light : Rgb(Rgb::Zero());
        case Quantity::luminance:
            return Rgb::Constant(lumens_per_watt * std::numbers::inv_pi * luminance(light));
        case Quantity::radiosity_weighted:
            return Rgb::Constant(luminance(light));
        default:
            return Rgb::Zero();
        }
    }

    void add_highlight(std::size_t sample, Index set, const Rgb& light) {
        for (std::size_t k = 0; k < view_.shows.size(); ++k) {
            add_to(view_.values[k][offset_ + sample], shown_of(view_.shows[k], set, light));
        }
    }

    Rgb value_of(const Show& show, const PointValues& light, std::size_t p) const {
        const auto row = static_cast<Eigen::Index>(p);
        const auto of = [row](const Values& values) { return Rgb(values.row(row).transpose().array()); };
        const SurfacePoint& x = points_[p];
        if (scene_.thermal && show.quantity != Quantity::sites) {
            // At a pixel the field may undershoot where nearly all heat that arrives is drawn: 0 K.
            const ThermalState state =
                thermal_state(scene_, scene_.mesh.material[x.face], light.H(row, 0)).value_or(ThermalState());
            return Rgb::Constant(thermal_value(show.quantity, state)) *
                   (shows_in_mirrors(show.quantity) ? colours_[p] : Rgb(Rgb::Ones()));
        }
        switch (show.quantity) {
        case Quantity::radiosity:
            return colours_[p] * of(light.B);
        case Quantity::direct:
            return colours_[p] * (of(light.E) + of(light.rho) * of(light.H_direct));
        case Quantity::indirect:
            return colours_[p] * of(light.rho) * of(light.H_indirect);
        case Quantity::group:
            for (const GroupValues& group : light.groups) {
                if (group.name == show.group) {
                    return colours_[p] * of(group.B);
                }
            }
            break;
        case Quantity::irradiance:
            return of(light.H);
        case Quantity::irradiance_direct:
            return of(light.H_direct);
        case Quantity::irradiance_indirect:
            return of(light.H_indirect);
        case Quantity::emission:
            return scene_.emission(x);
        case Quantity::reflectance:
            return scene_.reflectance(x);
        case Quantity::luminance:
            return Rgb::Constant(lumens_per_watt * std::numbers::inv_pi * luminance(colours_[p] * of(light.B)));
        case Quantity::illuminance:
            return Rgb::Constant(lumens_per_watt * luminance(of(light.H)));
        case Quantity::radiosity_weighted:
            return Rgb::Constant(luminance(colours_[p] * of(light.B)));
        case Quantity::irradiance_weighted:
            return Rgb::Constant(luminance(of(light.H)));
        case Quantity::sites:
            // Lit by a headlight, so that shapes are visible.
            return Rgb::Constant(0.25 + 0.45 * std::abs(x.normal.dot(directions_[numbers_[p]])));
        case Quantity::temperature:
        case Quantity::net_flux:
        case Quantity::error:
        case Quantity::illuminance_error:
        case Quantity::basis:
            break;
        }
        throw InternalError("picture: a quantity not evaluated here");
    }

    void add_basis(const Show& show, std::vector<Pixel>& values) {
        parallel_for(points_.size(), 1024, execution_, [&](std::size_t begin, std::size_t end, unsigned) {
            std::vector<BasisRow> rows(end - begin);
            basis_.evaluate(std::span(points_).subspan(begin, end - begin), rows);
            for (std::size_t p = begin; p < std::min(end, seen_directly_); ++p) {
                const BasisRow& row = rows[p - begin];
                double sum = 0.0;
                for (std::size_t i = 0; i < row.element.size(); ++i) {
                    sum += !show.element || row.element[i] == *show.element ? row.weight[i] : 0.0;
                }
                values[offset_ + numbers_[p]] = pixel_of(Rgb::Constant(sum));
            }
        });
    }

    /// BakeResult::errors at the points of the picture.
    void add_error(const PointValues& light, const Show& show, std::vector<Pixel>& values) {
        const ErrorsAt errors = errors_->of(points_, light, execution_);
        const Values shown = show.quantity == Quantity::error ? errors.error : lumens_per_watt * errors.irradiance;
        for (std::size_t p = 0; p < seen_directly_; ++p) {
            values[offset_ + numbers_[p]] = pixel_of(Rgb::Constant(shown(static_cast<Eigen::Index>(p), 0)));
        }
    }

    /// The sky, or the surroundings of a thermal scene, where rays leave it.
    void add_sky(const Show& show, std::vector<Pixel>& values) const {
        const bool surrounded = scene_.thermal && scene_.thermal->surroundings;
        if (!surrounded && !scene_.has_sky()) {
            return;
        }
        const double from_surroundings = surrounded ? excess_power(*scene_.thermal->surroundings, 0.0) : 0.0;
        const Index set = parts_.direct->sets().sky;
        const auto from = [&](const Vec3& direction, const Rgb& share) {
            return shown_of(show, set,
                            share * (surrounded ? Rgb(Rgb::Constant(from_surroundings))
                                                : Rgb(std::numbers::pi * scene_.sky_radiance(direction))));
        };
        for (std::size_t i = 0; i < batch_.size(); ++i) {
            if (view_.seen[offset_ + i] == CameraHit::nothing) {
                values[offset_ + i] = pixel_of(from(directions_[i], Rgb::Ones()));
            }
        }
        for (std::size_t i = 0; i < in_mirrors_.size(); ++i) {
            for (const SeenInMirror& sight : in_mirrors_[i]) {
                if (sight.hit.face == none) {
                    add_to(values[offset_ + i], from(sight.direction, sight.colour));
                }
            }
        }
    }

    const BakeResult& result_;
    const Scene& scene_;
    const Basis& basis_;
    FieldParts parts_;
    View& view_;
    CameraRays camera_;
    PartOfPhase progress_;
    Execution execution_;
    bool lit_ = false;               ///< some picture needs the light
    std::optional<ErrorMap> errors_; ///< if some picture shows them

    // Of the batch:
    std::size_t offset_ = 0; ///< number of its first sample
    std::vector<SurfacePoint> batch_;
    std::vector<Vec3> directions_;
    std::vector<SurfacePoint> points_;                  ///< those on fronts
    std::vector<std::size_t> numbers_;                  ///< their numbers in the batch
    std::vector<Rgb> colours_;                          ///< of the mirrors they are seen in
    std::size_t seen_directly_ = 0;                     ///< the first of them; the others are seen in mirrors
    std::vector<std::vector<SeenInMirror>> in_mirrors_; ///< of each sample; empty if nothing reflects specularly
    std::vector<std::vector<SeenGloss>> glossy_;        ///< likewise
};

void check(const BakeResult& result, const ViewOptions& options, const std::vector<Show>& shows,
           const Execution& execution) {
    check_view(options);
    check_shows(*result.scene, shows);
    for (const Show& show : shows) {
        if (show.element && *show.element >= result.sites->size()) {
            throw UsageError("--element " + std::to_string(*show.element) +
                             ": there is no such element; they are numbered from 0 to " +
                             std::to_string(result.sites->size() - 1));
        }
        if (shows_error(show) && !result.error) {
            throw UsageError(std::string("--show ") +
                             (show.quantity == Quantity::error ? "error" : "illuminance-error") +
                             ": there is no error estimate; remove --error-points 0");
        }
        if (show.quantity == Quantity::illuminance_error && !knows_error_of_irradiance(result)) {
            throw UsageError("--show illuminance-error: nothing is reflected, and the error was not estimated; read "
                             "the illuminance with sensors, whose errors are (--grid, or --at with normals)");
        }
        if (show.quantity == Quantity::group && !result.has_groups()) {
            throw UsageError("--show group:" + show.group + ": the light groups were baked together (--light-groups)");
        }
    }
    const double samples = static_cast<double>(options.width * options.height) * static_cast<double>(options.samples);
    require_memory(samples * (1.0 + sizeof(Pixel) * static_cast<double>(shows.size())), execution.memory_left(),
                   "the samples of the pictures",
                   "give a smaller --size, fewer --samples, or fewer pictures at a time");
}

/// The mean over each pixel of colour(sample).
template <class Colour> Image averaged(const View& view, const Execution& execution, const Colour& colour) {
    const ViewOptions& options = view.options;
    Image image{options.width, options.height, {}};
    image.pixels.resize(options.width * options.height);
    parallel_for(image.pixels.size(), 4096, execution, [&](std::size_t begin, std::size_t end, unsigned) {
        for (std::size_t pixel = begin; pixel < end; ++pixel) {
            Rgb sum = Rgb::Zero();
            for (std::size_t s = pixel * options.samples; s < (pixel + 1) * options.samples; ++s) {
                sum += colour(s);
            }
            image.pixels[pixel] = pixel_of(sum / static_cast<double>(options.samples));
        }
    });
    return image;
}

void draw_sites(const BakeResult& result, const ViewOptions& options, Image& image) {
    const CameraRays camera(options.camera, options.width, options.height);
    const Mesh& mesh = result.scene->mesh;
    for (const SurfacePoint& site : result.sites->points) {
        const Vec3 way = site.position - camera.eye();
        const auto place = camera.place_of(site.position);
        if (!place || !(mesh.face_normal(site).dot(way) < 0.0)) {
            continue;
        }
        const Hit hit =
            first_shown(mesh, result.system->tracer().engine(), {camera.eye(), way, none}, options.cull_backs);
        if (hit.face == site.face || hit.t > 1.0 - 1e-6) { // on an edge another face may be hit slightly earlier
            draw_disc(image, (*place)[0], (*place)[1], dot_radius, dot_colour);
        }
    }
}

} // namespace

void check_view(const ViewOptions& options) {
    const auto grid = static_cast<std::size_t>(std::lround(std::sqrt(static_cast<double>(options.samples))));
    if (options.samples == 0 || grid * grid != options.samples) {
        throw UsageError("--samples " + std::to_string(options.samples) +
                         ": must be a square number, such as 1, 4, 9 or 16");
    }
    if (options.width == 0 || options.height == 0 || options.width > 32768 || options.height > 32768) {
        throw UsageError("--size: width and height must be from 1 to 32768");
    }
}

View look(const BakeResult& result, const ViewOptions& options, const std::vector<Show>& shows,
          const Execution& execution) {
    check(result, options, shows, execution);
    View view{options, shows, {}, {}, 0, 0};
    const std::size_t samples = options.width * options.height * options.samples;
    view.seen.reserve(samples); // filled batch by batch: a large picture takes a while to fill, even with nothing
    view.values.resize(shows.size());
    for (std::vector<Pixel>& values : view.values) {
        values.reserve(samples);
    }
    Look(result, execution, view).take();
    return view;
}

double exposure_of(const View& view, std::size_t show) {
    std::vector<float> surfaces, all;
    for (std::size_t s = 0; s < view.seen.size(); ++s) {
        const auto bright = static_cast<float>(luminance(rgb_of(view.values[show][s])));
        if (view.seen[s] == CameraHit::surface) {
            surfaces.push_back(bright);
        } else if (view.seen[s] != CameraHit::back && surfaces.empty()) {
            all.push_back(bright);
        }
    }
    return exposure_for(surfaces.empty() ? std::move(all) : std::move(surfaces));
}

ColourScale scale_of(const View& view, std::size_t show, bool logarithmic) {
    const Quantity quantity = view.shows[show].quantity;
    const bool without_lamps = quantity == Quantity::luminance || quantity == Quantity::radiosity_weighted;
    std::vector<float> values;
    for (std::size_t s = 0; s < view.seen.size(); ++s) {
        if (view.seen[s] == CameraHit::surface || (view.seen[s] == CameraHit::lamp && !without_lamps)) {
            values.push_back(view.values[show][s][0]);
        }
    }
    return scale_for(values, logarithmic);
}

Image develop(const BakeResult& result, const View& view, std::size_t show, const Development& how,
              const Execution& execution) {
    const Show& what = view.shows[show];
    const Colouring colouring = colouring_of(what.quantity);
    const bool light_around = colouring == Colouring::map || colouring == Colouring::dots;
    const bool sky = how.sky && !how.background && shows_sky(what.quantity);
    Image image = averaged(view, execution, [&](std::size_t s) -> Rgb {
        const Rgb value = rgb_of(view.values[show][s]);
        if (view.seen[s] == CameraHit::back) {
            return dark_grey;
        }
        if (view.seen[s] == CameraHit::nothing && !sky) {
            return how.background.value_or(light_around ? light_neutral : neutral);
        }
        switch (colouring) {
        case Colouring::light:
            return tone_map(value, how.exposure, how.curve);
        case Colouring::map:
            return colour_map(how.scale.position(value[0]));
        case Colouring::plain:
        case Colouring::dots:
            break;
        }
        return value;
    });
    if (colouring == Colouring::dots) {
        draw_sites(result, view.options, image);
    } else if (colouring == Colouring::map) {
        return with_colour_bar(image, how.scale, what.title);
    }
    return image;
}

Image linear_picture(const View& view, std::size_t show, const std::optional<Rgb>& background,
                     const Execution& execution) {
    const Quantity quantity = view.shows[show].quantity;
    const bool radiance = quantity == Quantity::radiosity || quantity == Quantity::direct ||
                          quantity == Quantity::indirect || quantity == Quantity::group ||
                          quantity == Quantity::emission;
    return averaged(view, execution, [&](std::size_t s) -> Rgb {
        if (view.seen[s] == CameraHit::nothing && background) {
            return *background;
        }
        return (radiance ? std::numbers::inv_pi : 1.0) * rgb_of(view.values[show][s]);
    });
}

} // namespace difusa
