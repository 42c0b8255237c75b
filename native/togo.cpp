// Seconds to a target by many composites at once, looked up in tables. The NumPy twin is in kinesics/synthesis/paths/togo.py.
#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <stdexcept>

namespace nb = nanobind;
using namespace nb::literals;

namespace {

using Tables = nb::ndarray<const float, nb::shape<-1, -1, -1>, nb::c_contig, nb::device::cpu>;
using Kinds = nb::ndarray<const std::int64_t, nb::shape<-1>, nb::c_contig, nb::device::cpu>;
// Ends of trails are the last columns of larger arrays; of places z and x stand one behind the other.
using Places = nb::ndarray<const float, nb::shape<-1, 2>, nb::device::cpu>;
using Numbers = nb::ndarray<const float, nb::shape<-1>, nb::device::cpu>;
using Paths = nb::ndarray<const std::int32_t, nb::shape<-1>, nb::device::cpu>;
using Out = nb::ndarray<float, nb::shape<-1, -1>, nb::c_contig, nb::device::cpu>;

// out(b, r): seconds to the target by trail r, bent by bends(b), which ends at places(r) having played paths(r).
void seconds_by(Tables tables, Kinds kinds, Paths paths, Places places, Places swerve, Numbers headings, Numbers travelled,
                Numbers times, Numbers bends, float target_z, float target_x, float per_fold, float farthest, float slowness,
                Out out) {
    const auto rows = std::int64_t(paths.shape(0)), knots = std::int64_t(tables.shape(1));
    const auto width = std::int64_t(tables.shape(2)), count = std::int64_t(kinds.shape(0));
    bool good = std::int64_t(out.shape(0)) == std::int64_t(bends.shape(0)) && std::int64_t(out.shape(1)) == rows && knots > 1 &&
                width > 1 && (times.shape(0) == 1 || std::int64_t(times.shape(0)) == rows);
    for (const auto shape : {places.shape(0), swerve.shape(0), headings.shape(0), travelled.shape(0)})
        good = good && std::int64_t(shape) == rows;
    for (std::int64_t r = 0; good && r < rows; ++r)
        good = paths(r) >= 0 && paths(r) < count && kinds(paths(r)) >= 0 && kinds(paths(r)) < std::int64_t(tables.shape(0));
    if (!good) throw std::invalid_argument("kinesics._native.seconds_by: shapes do not fit");
    const float last = float(double(knots) - 1.001), bearings = float(width - 1), round = float(1.0 / (2.0 * 3.14159265358979323846));
    for (std::int64_t r = 0; r < rows; ++r) {
        const float *table = tables.data() + kinds(paths(r)) * knots * width;
        const float begun = times(times.shape(0) == 1 ? 0 : r);
        for (std::int64_t b = 0; b < std::int64_t(bends.shape(0)); ++b) {
            const float z = target_z - (places(r, 0) + bends(b) * swerve(r, 0));
            const float x = target_x - (places(r, 1) + bends(b) * swerve(r, 1));
            const float away = std::sqrt(z * z + x * x);
            const float step = std::min(std::log1p(away) * per_fold, last);
            float turn = (std::atan2(x, z) - (headings(r) + bends(b) * travelled(r))) * round;
            turn = (turn - std::floor(turn)) * bearings;
            const float low = std::floor(step), sector = std::min(std::floor(turn), bearings - 1.f);
            // what is no number stays none, and within the tables
            const bool told = low >= 0.f && sector >= 0.f;
            const float part = step - low, slant = turn - sector;
            const float *at = table + (told ? std::int64_t(low) * width + std::int64_t(sector) : 0);
            const float near = at[0] + slant * (at[1] - at[0]), far = at[width] + slant * (at[width + 1] - at[width]);
            out(b, r) = begun + (near + part * (far - near) + std::max(away - farthest, 0.f) * slowness);
        }
    }
}

}  // namespace

void bind_togo(nb::module_ &m) {
    m.def("seconds_by", &seconds_by, "tables"_a.noconvert(), "kinds"_a.noconvert(), "paths"_a.noconvert(), "places"_a.noconvert(),
          "swerve"_a.noconvert(), "headings"_a.noconvert(), "travelled"_a.noconvert(), "times"_a.noconvert(),
          "bends"_a.noconvert(), "target_z"_a, "target_x"_a, "per_fold"_a, "farthest"_a, "slowness"_a, "out"_a.noconvert());
}
