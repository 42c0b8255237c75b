// Points that joints carry, and how deep capsules round bones are in each other. The NumPy twins are in kinesics/body/feet.py
// and kinesics/body/capsules.py.
#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <stdexcept>

#include "quaternion.hpp"

namespace nb = nanobind;
using namespace nb::literals;
using kinesics::dot;

namespace {

using In1 = nb::ndarray<const double, nb::shape<-1>, nb::c_contig, nb::device::cpu>;
using In2 = nb::ndarray<const double, nb::shape<-1, -1>, nb::c_contig, nb::device::cpu>;
using In3 = nb::ndarray<const double, nb::shape<-1, -1, -1>, nb::c_contig, nb::device::cpu>;
using Numbers = nb::ndarray<const std::int32_t, nb::shape<-1>, nb::c_contig, nb::device::cpu>;
using Out2 = nb::ndarray<double, nb::shape<-1, -1>, nb::c_contig, nb::device::cpu>;
using Out3 = nb::ndarray<double, nb::shape<-1, -1, -1>, nb::c_contig, nb::device::cpu>;

bool all_below(const Numbers &numbers, std::int64_t limit) {
    return std::all_of(numbers.data(), numbers.data() + numbers.shape(0), [&](std::int32_t n) { return n >= 0 && n < limit; });
}

// out(f, n): where the point n is that joint joints(n) carries at offsets(n).
void carried_points(In3 positions, In3 rotations, Numbers joints, In2 offsets, Out3 out) {
    const auto frames = std::int64_t(out.shape(0)), points = std::int64_t(out.shape(1)), count = std::int64_t(positions.shape(1));
    if (!(out.shape(2) == 3 && std::int64_t(positions.shape(0)) == frames && positions.shape(2) == 3 &&
          std::int64_t(rotations.shape(0)) == frames && std::int64_t(rotations.shape(1)) == count && rotations.shape(2) == 4 &&
          std::int64_t(joints.shape(0)) == points && std::int64_t(offsets.shape(0)) == points && offsets.shape(1) == 3 &&
          all_below(joints, count)))
        throw std::invalid_argument("kinesics._native.carried_points: shapes do not fit");
    const double *place = positions.data(), *turned = rotations.data(), *fixed = offsets.data();
    const std::int32_t *carriers = joints.data();
    double *to = out.data();
    nb::gil_scoped_release release;
    for (std::int64_t f = 0; f < frames; ++f, place += 3 * count, turned += 4 * count)
        for (std::int64_t n = 0; n < points; ++n, to += 3) {
            kinesics::turn(turned + 4 * carriers[n], fixed + 3 * n, to);
            for (int i = 0; i < 3; ++i) to[i] += place[3 * carriers[n] + i];
        }
}

double clipped(double value) { return std::min(std::max(value, 0.0), 1.0); }

// How near the segments from a along u and from b along v come (Ericson 2005, 5.1.9).
double segment_distance(const double *a, const double *u, const double *b, const double *v) {
    const double between[3] = {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
    const double uu = dot(u, u), vv = dot(v, v), uv = dot(u, v), u_gap = dot(u, between), v_gap = dot(v, between);
    const double across = uu * vv - uv * uv;
    // parallel: any point of a will do to begin with
    double s = across > 1e-12 * uu * vv ? clipped((uv * v_gap - u_gap * vv) / across) : 0.0;
    const double t = vv > 0.0 ? clipped((uv * s + v_gap) / vv) : 0.0;
    s = uu > 0.0 ? clipped((uv * t - u_gap) / uu) : 0.0;
    double nearest[3];
    for (int i = 0; i < 3; ++i) nearest[i] = between[i] + s * u[i] - t * v[i];
    return kinesics::length(nearest);
}

// out(f, p): by how much capsules first(p) and second(p) interpenetrate, minus infinity where by less than about `least`.
void capsule_depths(In3 starts, In3 ends, Numbers first, Numbers second, In1 reach, double least, Out2 out) {
    const auto frames = std::int64_t(out.shape(0)), pairs = std::int64_t(out.shape(1)), count = std::int64_t(starts.shape(1));
    if (!(std::int64_t(starts.shape(0)) == frames && starts.shape(2) == 3 && std::int64_t(ends.shape(0)) == frames &&
          std::int64_t(ends.shape(1)) == count && ends.shape(2) == 3 && std::int64_t(first.shape(0)) == pairs &&
          std::int64_t(second.shape(0)) == pairs && std::int64_t(reach.shape(0)) == pairs && all_below(first, count) &&
          all_below(second, count)))
        throw std::invalid_argument("kinesics._native.capsule_depths: shapes do not fit");
    const double *from = starts.data(), *to = ends.data(), *radii = reach.data();
    const std::int32_t *one = first.data(), *other = second.data();
    double *depth = out.data();
    nb::gil_scoped_release release;
    for (std::int64_t f = 0; f < frames; ++f, from += 3 * count, to += 3 * count)
        for (std::int64_t p = 0; p < pairs; ++p, ++depth) {
            const double *a = from + 3 * one[p], *a_end = to + 3 * one[p], *b = from + 3 * other[p], *b_end = to + 3 * other[p];
            double u[3], v[3], apart[3];
            for (int i = 0; i < 3; ++i) {
                u[i] = a_end[i] - a[i];
                v[i] = b_end[i] - b[i];
                apart[i] = 0.5 * (a[i] + a_end[i] - b[i] - b_end[i]);
            }
            // segments whose middles are farther apart than half their lengths and their radii cannot touch
            const double most = 0.5 * (kinesics::length(u) + kinesics::length(v)) + radii[p] - least;
            *depth = dot(apart, apart) < most * most ? radii[p] - segment_distance(a, u, b, v)
                                                     : -std::numeric_limits<double>::infinity();
        }
}

}  // namespace

void bind_body(nb::module_ &m) {
    m.def("carried_points", &carried_points, "positions"_a.noconvert(), "rotations"_a.noconvert(), "joints"_a.noconvert(),
          "offsets"_a.noconvert(), "out"_a.noconvert());
    m.def("capsule_depths", &capsule_depths, "starts"_a.noconvert(), "ends"_a.noconvert(), "first"_a.noconvert(),
          "second"_a.noconvert(), "reach"_a.noconvert(), "least"_a, "out"_a.noconvert());
}
