// Legs that reach, in all frames: the knee bent, the leg swung, the foot turned in the world as it was. The NumPy twin is in
// kinesics/synthesis/embodiment/inverse_kinematics.py.
#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <stdexcept>

#include "quaternion.hpp"

namespace nb = nanobind;
using namespace nb::literals;
using kinesics::cross;
using kinesics::dot;
using kinesics::length;
using kinesics::multiply;
using kinesics::turn;
using kinesics::undo;

namespace {

using In2 = nb::ndarray<const double, nb::shape<-1, -1>, nb::c_contig, nb::device::cpu>;
using In3 = nb::ndarray<const double, nb::shape<-1, -1, -1>, nb::c_contig, nb::device::cpu>;
using Joints = nb::ndarray<const std::int32_t, nb::shape<2, 6>, nb::c_contig, nb::device::cpu>;
using Out2 = nb::ndarray<double, nb::shape<-1, -1>, nb::c_contig, nb::device::cpu>;
using Out3 = nb::ndarray<double, nb::shape<-1, -1, -1>, nb::c_contig, nb::device::cpu>;

// The least rotation from direction a to direction b, none where either has no length.
void between(const double *a, const double *b, double *to) {
    const double by_a = 1.0 / std::max(length(a), 1e-12), by_b = 1.0 / std::max(length(b), 1e-12);
    double one[3], halfway[3], vector[3];
    for (int n = 0; n < 3; ++n) one[n] = by_a * a[n], halfway[n] = one[n] + by_b * b[n];
    const double w = 0.5 * length(halfway);
    to[0] = 1.0, to[1] = to[2] = to[3] = 0.0;
    if (!(w > 1e-9)) return;
    cross(one, halfway, vector);
    to[0] = w;
    for (int n = 0; n < 3; ++n) to[n + 1] = vector[n] / (2.0 * w);
    const double size = std::sqrt(to[0] * to[0] + dot(to + 1, to + 1));
    for (int n = 0; n < 4; ++n) to[n] /= size;
}

struct Limits {
    double soft, straightest, backward;

    double softened(double asked, double now, double whole) const {
        const double most = straightest * whole, start = std::min(std::max(now, soft * whole), most - 1e-9 * whole);
        if (asked <= start) return asked;
        const double room = most - start;
        return start - room * std::expm1(-(asked - start) / room);
    }

    // Turns in the world of what hangs on the knee, then of the whole leg; and by how much the target is missed.
    double reach(const double *hip, const double *knee, const double *ankle, const double *target, const double *axis,
                 double *bend, double *swing) const {
        double upper[3], lower[3], aim[3], whole[3], reached[3];
        for (int n = 0; n < 3; ++n) {
            upper[n] = knee[n] - hip[n];
            lower[n] = ankle[n] - knee[n];
            aim[n] = target[n] - hip[n];
            whole[n] = ankle[n] - hip[n];
        }
        const double l1 = length(upper), l2 = length(lower), now = length(whole), asked = length(aim);
        bend[0] = 1.0, bend[1] = bend[2] = bend[3] = 0.0;
        if (asked != now) {
            const double far = std::max(softened(asked, now, l1 + l2), std::abs(l1 - l2) + 1e-4 * (l1 + l2));
            // u·(v turned by an angle about the axis) = a cos + b sin + c must become what the law of cosines asks of it
            double across[3];
            cross(axis, lower, across);
            const double scale = 1.0 / (l1 * l2), c = dot(axis, upper) * dot(axis, lower) * scale;
            const double a = dot(upper, lower) * scale - c, b = dot(upper, across) * scale, size = std::hypot(a, b);
            const double wanted = 0.5 * (far * far - l1 * l1 - l2 * l2) * scale - c, bent = -std::atan2(b, a);
            // where a bone lies along the hinge, turning about it changes nothing
            double angle = size > 1e-12 ? std::acos(std::min(std::max(wanted / size, -1.0), 1.0)) - std::abs(bent) : 0.0;
            if (bent < backward) angle = -angle;
            const double sine = std::sin(0.5 * angle);
            bend[0] = std::cos(0.5 * angle);
            for (int n = 0; n < 3; ++n) bend[n + 1] = sine * axis[n];
        }
        turn(bend, lower, reached);
        for (int n = 0; n < 3; ++n) reached[n] += upper[n];
        between(reached, aim, swing);
        return std::abs(length(reached) - asked);
    }
};

// joints: of each leg femur, tibia, foot, and their parents. `out` begins as the rotations that are given.
void reach_legs(In3 positions, In3 world, In3 targets, Joints joints, In2 hinges, double soft, double straightest, double backward,
                Out3 out, Out2 misses) {
    const auto frames = std::int64_t(out.shape(0)), count = std::int64_t(out.shape(1));
    auto fits = [&](const auto &array, std::int64_t columns, std::size_t width) {
        return std::int64_t(array.shape(0)) == frames && std::int64_t(array.shape(1)) == columns && array.shape(2) == width;
    };
    bool good = fits(out, count, 4) && fits(positions, count, 3) && fits(world, count, 4) && fits(targets, 2, 3) &&
                hinges.shape(0) == 2 && hinges.shape(1) == 3 && std::int64_t(misses.shape(0)) == frames && misses.shape(1) == 2;
    for (int n = 0; n < 12; ++n) good = good && joints.data()[n] >= 0 && joints.data()[n] < count;
    if (!good) throw std::invalid_argument("kinesics._native.reach_legs: shapes do not fit");
    const Limits limits{soft, straightest, backward};
    const double *place = positions.data(), *facing = world.data(), *goals = targets.data(), *axes = hinges.data();
    const std::int32_t *legs = joints.data();
    double *local = out.data(), *missed = misses.data();
    nb::gil_scoped_release release;
    for (std::int64_t f = 0; f < frames; ++f, place += 3 * count, facing += 4 * count, local += 4 * count) {
        for (int k = 0; k < 2; ++k) {
            const std::int32_t *leg = legs + 6 * k, femur = leg[0], tibia = leg[1], foot = leg[2];
            double hinge[3], bend[4], swing[4], lower[4], own[4], above[4];
            turn(facing + 4 * tibia, axes + 3 * k, hinge);
            missed[2 * f + k] = limits.reach(place + 3 * femur, place + 3 * tibia, place + 3 * foot, goals + 6 * f + 3 * k, hinge,
                                             bend, swing);
            multiply(swing, bend, lower);
            // each is the old orientation in the world, turned, seen from its parent, turned or not
            multiply(swing, facing + 4 * femur, own);
            undo(facing + 4 * leg[3], own, local + 4 * femur);
            multiply(lower, facing + 4 * tibia, own);
            multiply(swing, facing + 4 * leg[4], above);
            undo(above, own, local + 4 * tibia);
            multiply(lower, facing + 4 * leg[5], above);
            undo(above, facing + 4 * foot, local + 4 * foot);
        }
    }
}

}  // namespace

void bind_legs(nb::module_ &m) {
    m.def("reach_legs", &reach_legs, "positions"_a.noconvert(), "world"_a.noconvert(), "targets"_a.noconvert(),
          "joints"_a.noconvert(), "hinges"_a.noconvert(), "soft"_a, "straightest"_a, "backward"_a, "out"_a.noconvert(),
          "misses"_a.noconvert());
}
