// Forward kinematics over all frames: world orientations and positions from rotations relative to the parents.
#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/optional.h>

#include <algorithm>
#include <cstdint>
#include <limits>
#include <optional>
#include <stdexcept>
#include <vector>

#include "threads.hpp"

namespace nb = nanobind;
using namespace nb::literals;

namespace {

using In2 = nb::ndarray<const double, nb::shape<-1, -1>, nb::c_contig, nb::device::cpu>;
using In3 = nb::ndarray<const double, nb::shape<-1, -1, -1>, nb::c_contig, nb::device::cpu>;
using Out3 = nb::ndarray<double, nb::shape<-1, -1, -1>, nb::c_contig, nb::device::cpu>;
using Parents = nb::ndarray<const std::int32_t, nb::shape<-1>, nb::c_contig, nb::device::cpu>;

constexpr std::int64_t kFramesAtOnce = 256;
// Below this much work, some 15 ms, threads cost more than they save: between calls they wait by spinning, and a performance, which
// asks for many such calls, was made half as quickly with two of them as with one where anything else ran.
constexpr std::int64_t kThreadedJoints = 1 << 19;

// One frame. World rotations go to `world`; positions only when wanted. Of all joints but the root those in `order`.
template <bool Positions>
inline void one_frame(const std::vector<std::int32_t> &order, const std::int32_t *parents, const double *shifts,
                      const double *rotations, const double *root, double *world, double *positions) {
    for (int c = 0; c < 4; ++c) world[c] = rotations[c];
    if constexpr (Positions)
        for (int c = 0; c < 3; ++c) positions[c] = root[c];
    for (const std::int64_t j : order) {
        const double *p = world + 4 * parents[j];
        const double *q = rotations + 4 * j;
        double *out = world + 4 * j;
        const double pw = p[0], px = p[1], py = p[2], pz = p[3];
        const double qw = q[0], qx = q[1], qy = q[2], qz = q[3];
        out[0] = pw * qw - px * qx - py * qy - pz * qz;
        out[1] = pw * qx + px * qw + py * qz - pz * qy;
        out[2] = pw * qy - px * qz + py * qw + pz * qx;
        out[3] = pw * qz + px * qy - py * qx + pz * qw;
        if constexpr (Positions) {
            const double *v = shifts + 3 * j;
            const double *from = positions + 3 * parents[j];
            double *to = positions + 3 * j;
            // v + 2 w u x v + 2 u x (u x v)
            const double tx = 2 * (py * v[2] - pz * v[1]);
            const double ty = 2 * (pz * v[0] - px * v[2]);
            const double tz = 2 * (px * v[1] - py * v[0]);
            to[0] = from[0] + v[0] + pw * tx + (py * tz - pz * ty);
            to[1] = from[1] + v[1] + pw * ty + (pz * tx - px * tz);
            to[2] = from[2] + v[2] + pw * tz + (px * ty - py * tx);
        }
    }
}

void forward_kinematics(Parents parents, In2 offsets, In3 rotations, std::optional<In2> roots,
                        std::optional<In3> translations, std::optional<Out3> world, std::optional<Out3> positions,
                        std::optional<Parents> wanted, int threads) {
    const auto frames = std::int64_t(rotations.shape(0)), joints = std::int64_t(rotations.shape(1));
    auto fits = [&](const auto &array, std::size_t width) {
        return !array || (array->shape(0) == std::size_t(frames) && array->shape(1) == std::size_t(joints) &&
                          array->shape(2) == width);
    };
    bool good = joints > 0 && rotations.shape(2) == 4 && parents.shape(0) == std::size_t(joints) &&
                offsets.shape(0) == std::size_t(joints) && offsets.shape(1) == 3 && fits(translations, 3) &&
                fits(world, 4) && fits(positions, 3);
    good = good && (!roots || (roots->shape(0) == std::size_t(frames) && roots->shape(1) == 3));
    good = good && (!positions || roots);
    for (std::int64_t j = 1; good && j < joints; ++j) good = parents(j) >= 0 && parents(j) < j;
    std::vector<std::int32_t> order, others;
    std::vector<bool> included(good ? std::size_t(joints) : 0, !wanted);
    for (std::size_t n = 0; good && wanted && n < wanted->shape(0); ++n) {
        good = (*wanted)(n) >= 0 && (*wanted)(n) < joints;
        // with all that it hangs on
        for (std::int32_t j = good ? (*wanted)(n) : 0; j > 0 && !included[std::size_t(j)]; j = parents(std::size_t(j)))
            included[std::size_t(j)] = true;
    }
    if (!good) throw std::invalid_argument("kinesics._native.forward_kinematics: shapes do not fit");
    for (std::int64_t j = 1; j < joints; ++j)
        (included[std::size_t(j)] ? order : others).push_back(std::int32_t(j));

    const std::int32_t *tree = parents.data();
    const double *fixed = offsets.data(), *q = rotations.data();
    const double *root = roots ? roots->data() : nullptr, *moving = translations ? translations->data() : nullptr;
    double *w = world ? world->data() : nullptr, *p = positions ? positions->data() : nullptr;
    nb::gil_scoped_release release;
    const std::int64_t parts = (frames + kFramesAtOnce - 1) / kFramesAtOnce;
    kinesics::parallel_for(parts, frames * std::int64_t(order.size() + 1) < kThreadedJoints ? 1 : threads, [&](std::int64_t part) {
        std::vector<double> scratch(w == nullptr ? std::size_t(4 * joints) : 0);
        const std::int64_t last = std::min(frames, (part + 1) * kFramesAtOnce);
        for (std::int64_t f = part * kFramesAtOnce; f < last; ++f) {
            double *to = w == nullptr ? scratch.data() : w + f * joints * 4;
            const double *shifts = moving == nullptr ? fixed : moving + f * joints * 3;
            if (p == nullptr)
                one_frame<false>(order, tree, shifts, q + f * joints * 4, nullptr, to, nullptr);
            else
                one_frame<true>(order, tree, shifts, q + f * joints * 4, root + f * 3, to, p + f * joints * 3);
            for (const std::int64_t j : others) {
                if (w != nullptr) std::fill_n(to + 4 * j, 4, std::numeric_limits<double>::quiet_NaN());
                if (p != nullptr) std::fill_n(p + (f * joints + j) * 3, 3, std::numeric_limits<double>::quiet_NaN());
            }
        }
    });
}

}  // namespace

void bind_kinematics(nb::module_ &m) {
    m.def("forward_kinematics", &forward_kinematics, "parents"_a.noconvert(), "offsets"_a.noconvert(),
          "rotations"_a.noconvert(), "root_positions"_a.noconvert().none(), "joint_translations"_a.noconvert().none(),
          "world"_a.noconvert().none(), "positions"_a.noconvert().none(), "wanted"_a.noconvert().none() = nb::none(),
          "threads"_a = 0);
}
