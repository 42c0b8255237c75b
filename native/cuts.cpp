// A cut of a live performance: how the two recordings differ there, what remains of the transition before, and how long this one
// takes. The twins in NumPy are in kinesics/synthesis/live/cuts.py, kinesics/synthesis/live/blends.py and
// kinesics/synthesis/embodiment/blending.py.
#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/array.h>
#include <nanobind/stl/vector.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <stdexcept>
#include <vector>

#include "quaternion.hpp"

namespace nb = nanobind;
using namespace nb::literals;
using kinesics::dot;
using kinesics::exponential;
using kinesics::length;
using kinesics::logarithm;
using kinesics::multiply;
using kinesics::Passing;
using kinesics::turn;
using kinesics::undo;

namespace {

using Poses = nb::ndarray<const double, nb::shape<3, -1, 4>, nb::c_contig, nb::device::cpu>;
using Places = nb::ndarray<const double, nb::shape<3, 3>, nb::c_contig, nb::device::cpu>;
using Parents = nb::ndarray<const std::int32_t, nb::shape<-1>, nb::c_contig, nb::device::cpu>;
using Vectors = nb::ndarray<const double, nb::shape<-1, 3>, nb::c_contig, nb::device::cpu>;
using Changed = nb::ndarray<double, nb::shape<-1, 3>, nb::c_contig, nb::device::cpu>;
using Numbers = nb::ndarray<const double, nb::shape<-1, 1>, nb::c_contig, nb::device::cpu>;
using Filled = nb::ndarray<double, nb::shape<-1, 1>, nb::c_contig, nb::device::cpu>;
using Limits = nb::ndarray<const double, nb::shape<-1>, nb::c_contig, nb::device::cpu>;
using Mask = nb::ndarray<const bool, nb::shape<-1>, nb::c_contig, nb::device::cpu>;
using Quaternion = std::array<double, 4>;

// The rotation of the joint that a body hangs on, the whole body turned about the vertical.
void faced(const double *pose, const std::vector<std::size_t> &above, std::size_t carrier, double yaw, double *to) {
    double turned[4] = {std::cos(0.5 * yaw), 0.0, std::sin(0.5 * yaw), 0.0};
    if (!above.empty()) {
        double over[4];
        std::copy_n(pose + 4 * above[0], 4, over);
        for (std::size_t k = 1; k < above.size(); ++k) multiply(over, pose + 4 * above[k], over);
        multiply(turned, over, turned);
        undo(over, turned, turned);
    }
    multiply(turned, pose + 4 * carrier, to);
}

// By how much what is entered differs from what is left, before, at and after the cut, and how quickly that changes.
void seam(Poses left, Poses entered, Places left_roots, Places entered_roots, Parents parents, Vectors arms,
          std::vector<std::size_t> above, std::size_t carrier, std::array<double, 2> turns, std::array<double, 2> aside,
          double pace, Changed offset, Changed velocity, Changed places, Changed moving) {
    const std::size_t joints = left.shape(1);
    bool good = joints > 0 && carrier < joints && entered.shape(1) == joints && parents.shape(0) == joints &&
                arms.shape(0) == joints && offset.shape(0) == joints + 1 && velocity.shape(0) == joints + 1 &&
                places.shape(0) == joints && moving.shape(0) == joints;
    for (std::size_t j = 1; good && j < joints; ++j) good = parents(j) >= 0 && std::size_t(parents(j)) < j;
    for (const auto j : above) good = good && j < joints;
    if (!good) throw std::invalid_argument("kinesics._native.seam: shapes do not fit");
    std::vector<double> apart(3 * 3 * (joints + 1)), body(2 * 3 * 3 * joints), world(4 * joints), pose(2 * 4 * joints);
    for (int k = 0; k < 3; ++k) {
        double *off = apart.data() + 3 * (joints + 1) * k;
        for (int side = 0; side < 2; ++side) {
            const double *given = (side ? entered : left).data() + 4 * joints * k;
            const double *root = (side ? entered_roots : left_roots).data() + 3 * k;
            double *q = pose.data() + 4 * joints * side, *at = body.data() + 3 * joints * (3 * side + k);
            std::copy_n(given, 4 * joints, q);
            faced(given, above, carrier, turns[side], q + 4 * carrier);
            const double cosine = std::cos(turns[side]), sine = std::sin(turns[side]);
            at[0] = cosine * root[0] + sine * root[2], at[1] = root[1], at[2] = -sine * root[0] + cosine * root[2];
            std::copy_n(q, 4, world.data());
            for (std::size_t j = 1; j < joints; ++j) {
                const auto parent = std::size_t(parents(j));
                double arm[3];
                turn(world.data() + 4 * parent, arms.data() + 3 * j, arm);
                for (int n = 0; n < 3; ++n) at[3 * j + n] = at[3 * parent + n] + arm[n];
                multiply(world.data() + 4 * parent, q + 4 * j, world.data() + 4 * j);
            }
        }
        for (std::size_t j = 0; j < joints; ++j) {
            double between[4];
            undo(pose.data() + 4 * j, pose.data() + 4 * (joints + j), between);
            logarithm(between, off + 3 * j);
        }
        for (int n = 0; n < 3; ++n) off[3 * joints + n] = body[3 * joints * (3 + k) + n] - body[3 * joints * k + n];
    }
    const double *early = apart.data(), *now = early + 3 * (joints + 1), *late = now + 3 * (joints + 1);
    for (std::size_t j = 0; j <= joints; ++j) {
        double change[3];
        for (int n = 0; n < 3; ++n) change[n] = late[3 * j + n] - early[3 * j + n];
        // a rotation vector leaps where it passes half a turn; such an offset has no velocity that could be told
        const bool told = dot(change, change) < 4.0;
        for (int n = 0; n < 3; ++n) {
            offset.data()[3 * j + n] = now[3 * j + n];
            velocity.data()[3 * j + n] = told ? change[n] * pace : 0.0;
        }
    }
    double *root = offset.data() + 3 * joints;
    root[0] = aside[0], root[2] = aside[1];
    for (std::size_t i = 0; i < 3 * joints; ++i) {
        const auto away = [&](int k) { return body[3 * joints * (3 + k) + i] - body[3 * joints * k + i]; };
        places.data()[i] = (away(1) - now[3 * joints + i % 3]) + root[i % 3];
        moving.data()[i] = (away(2) - away(0)) * pace;
    }
}

// Offset and velocity of a cut at which an earlier transition is not over: what remains of that ends here. In place.
void absorbed(Changed offset, Changed velocity, Vectors earlier, Vectors its_velocity, Numbers before, Numbers after,
              Numbers share, double since, double instant) {
    const std::size_t rows = offset.shape(0);
    for (const auto its : {velocity.shape(0), earlier.shape(0), its_velocity.shape(0), before.shape(0), after.shape(0), share.shape(0)})
        if (its != rows || rows == 0) throw std::invalid_argument("kinesics._native.absorbed: shapes do not fit");
    for (std::size_t j = 0; j < rows; ++j) {
        double apart[3][3];
        for (int k = 0; k < 3; ++k) {
            const double time = k == 0 ? -instant : k == 1 ? 0.0 : instant;
            double remains[3];
            const Passing passing(before.data()[j], after.data()[j], share.data()[j], since + time);
            passing.add(earlier.data() + 3 * j, its_velocity.data() + 3 * j, remains);
            for (int n = 0; n < 3; ++n) apart[k][n] = offset.data()[3 * j + n] + time * velocity.data()[3 * j + n];
            if (j + 1 == rows) {
                for (int n = 0; n < 3; ++n) apart[k][n] -= remains[n];
                continue;
            }
            double gone[4], turned[4], between[4];
            exponential(remains, gone);
            exponential(apart[k], turned);
            undo(gone, turned, between);
            logarithm(between, apart[k]);
        }
        for (int n = 0; n < 3; ++n) {
            offset.data()[3 * j + n] = apart[1][n];
            velocity.data()[3 * j + n] = (apart[2][n] - apart[0][n]) / (2.0 * instant);
        }
    }
}

struct Rules {
    double peak, peak_of_velocity, farthest, shortest, longest, slowest, carried, instant;

    // Seconds to either side of a cut, so that nothing is accelerated more than it may be.
    double needed(double offset, double velocity, double most) const {
        const double a = std::max(most, 1e-9), linear = 0.5 * velocity * peak_of_velocity / a, square = 0.5 * offset * peak / a;
        return 0.5 * (linear + std::sqrt(linear * linear + 4.0 * square));
    }
};

// How long a transition takes to either side and which share each bears before the cut; velocities in place. Returns the longest.
double paced(Vectors offset, Changed velocity, Vectors places, Vectors moving, Parents which, Limits spared, Mask loose,
             Limits slowly, std::array<double, 3> stays, double seconds, std::array<double, 8> rules, Filled before, Filled after,
             Filled share) {
    const std::size_t rows = offset.shape(0), joints = places.shape(0), chosen = which.shape(0);
    bool good = spared.shape(0) == chosen + joints && moving.shape(0) == joints;
    for (const auto its : {velocity.shape(0), loose.shape(0), slowly.shape(0), before.shape(0), after.shape(0), share.shape(0)})
        good = good && its == rows;
    for (std::size_t k = 0; good && k < chosen; ++k) good = which(k) >= 0 && std::size_t(which(k)) < rows;
    if (!good) throw std::invalid_argument("kinesics._native.paced: shapes do not fit");
    const Rules r{rules[0], rules[1], rules[2], rules[3], rules[4], rules[5], rules[6], rules[7]};
    double half = 0.0;
    for (std::size_t k = 0; k < chosen; ++k) {
        const double *off = offset.data() + 3 * which(k), *speed = velocity.data() + 3 * which(k);
        half = std::max(half, r.needed(length(off), length(speed), spared(k)));
    }
    for (std::size_t j = 0; j < joints; ++j) {
        double off[3];
        for (int n = 0; n < 3; ++n) off[n] = places(j, n) - stays[n];
        half = std::max(half, r.needed(length(off), length(moving.data() + 3 * j), spared(chosen + j)));
    }
    half = std::min(std::max(half, r.shortest), r.longest);
    const double first = std::min(half, seconds);
    // what there is no time for before the cut has to be done after it
    const double last = std::min(std::sqrt(2.0 * half * half - first * first), r.longest);
    const double longer = std::max({first, last, 1e-9}), least = std::min(r.shortest / longer, 1.0);
    double latest = 0.0;
    for (std::size_t j = 0; j < rows; ++j) {
        double pace = 1.0;
        if (loose(j)) {
            double *v = velocity.data() + 3 * j;
            const double speed = length(v), carried = 0.5 * r.farthest * longer * std::max(speed, 1e-9);
            const double time = r.needed(length(offset.data() + 3 * j), speed, slowly(j));
            const double wanted = std::min(std::max(time, longer), r.slowest) / longer;
            pace = std::min(std::max(r.carried / carried, least), std::max(wanted, 1.0));
            const double kept = std::min(r.carried / (carried * pace), 1.0);
            for (int n = 0; n < 3; ++n) v[n] *= kept;
        }
        // what takes longer cannot have begun before it was known
        const double early = first * std::min(pace, 1.0), late = last * pace;
        before.data()[j] = std::max(early, r.instant);
        after.data()[j] = late;
        share.data()[j] = early * early / (early * early + late * late);
        latest = std::max(latest, late);
    }
    return latest;
}

}  // namespace

void bind_cuts(nb::module_ &m) {
    m.def("seam", &seam, "left"_a.noconvert(), "entered"_a.noconvert(), "left_roots"_a.noconvert(), "entered_roots"_a.noconvert(),
          "parents"_a.noconvert(), "arms"_a.noconvert(), "above"_a, "carrier"_a, "turns"_a, "aside"_a, "pace"_a,
          "offset"_a.noconvert(), "velocity"_a.noconvert(), "places"_a.noconvert(), "moving"_a.noconvert());
    m.def("absorbed", &absorbed, "offset"_a.noconvert(), "velocity"_a.noconvert(), "earlier"_a.noconvert(),
          "its_velocity"_a.noconvert(), "before"_a.noconvert(), "after"_a.noconvert(), "share"_a.noconvert(), "since"_a, "instant"_a);
    m.def("paced", &paced, "offset"_a.noconvert(), "velocity"_a.noconvert(), "places"_a.noconvert(), "moving"_a.noconvert(),
          "which"_a.noconvert(), "spared"_a.noconvert(), "loose"_a.noconvert(), "slowly"_a.noconvert(), "stays"_a, "seconds"_a,
          "rules"_a, "before"_a.noconvert(), "after"_a.noconvert(), "share"_a.noconvert());
}
