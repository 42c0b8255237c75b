// What is done in every frame of a live performance: transitions added, a leg that reaches. The twins in NumPy and plain Python
// are in kinesics/synthesis/live/blends.py and kinesics/synthesis/live/leg.py.
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
#include <utility>
#include <vector>

#include "quaternion.hpp"
#include "ranges.hpp"

namespace nb = nanobind;
using namespace nb::literals;
using kinesics::cross;
using kinesics::dot;
using kinesics::exponential;
using kinesics::length;
using kinesics::logarithm;
using kinesics::multiply;
using kinesics::Passing;
using kinesics::turn;
using kinesics::undo;
using kinesics::Range;
using kinesics::Ranges;

namespace {

using Rotations = nb::ndarray<double, nb::shape<-1, 4>, nb::c_contig, nb::device::cpu>;
using Quaternions = nb::ndarray<const double, nb::shape<-1, 4>, nb::c_contig, nb::device::cpu>;
using Vectors = nb::ndarray<const double, nb::shape<-1, 3>, nb::c_contig, nb::device::cpu>;
using Numbers = nb::ndarray<const double, nb::shape<-1, 1>, nb::c_contig, nb::device::cpu>;
using Quaternion = std::array<double, 4>;
using Vector = std::array<double, 3>;

nb::tuple plain(const Quaternion &q) { return nb::make_tuple(q[0], q[1], q[2], q[3]); }
nb::tuple plain(const Vector &v) { return nb::make_tuple(v[0], v[1], v[2]); }

// What a transition adds so many seconds from its cut to the rotations, in place; returns what it adds to the root's place.
nb::tuple blended(Rotations rotations, Vectors offset, Vectors velocity, Numbers before, Numbers after, Numbers share,
                  double time) {
    const auto joints = rotations.shape(0);
    for (const auto rows : {offset.shape(0), velocity.shape(0), before.shape(0), after.shape(0), share.shape(0)})
        if (rows != joints + 1) throw std::invalid_argument("kinesics._native.blended: shapes do not fit");
    Vector added{};
    for (std::size_t j = 0; j <= joints; ++j) {
        const Passing passing(before.data()[j], after.data()[j], share.data()[j], time);
        passing.add(offset.data() + 3 * j, velocity.data() + 3 * j, added.data());
        if (j == joints) break;
        double by[4];
        exponential(added.data(), by);
        double *own = rotations.data() + 4 * j;
        multiply(own, by, own);
    }
    return plain(added);
}

// The joints between root and soles, parents first, the root at their head.
class Chain {
  public:
    Chain(std::vector<std::size_t> joints, std::vector<std::size_t> above, std::vector<Vector> offsets)
        : joints(std::move(joints)), above(std::move(above)), offsets(std::move(offsets)) {
        bool good = !this->joints.empty() && this->joints.size() == this->above.size() && this->joints.size() == this->offsets.size();
        for (std::size_t k = 1; good && k < this->joints.size(); ++k) good = this->above[k] < k;
        if (!good) throw std::invalid_argument("kinesics._native.Chain: no chain");
    }

    // Their rotations, places and orientations in the world.
    nb::tuple placed(Quaternions rotations, const Vector &root) const {
        std::vector<Vector> places(joints.size());
        std::vector<Quaternion> local(joints.size()), world(joints.size());
        for (std::size_t k = 0; k < joints.size(); ++k) {
            if (joints[k] >= rotations.shape(0)) throw std::invalid_argument("kinesics._native.Chain: too few joints");
            std::copy_n(rotations.data() + 4 * joints[k], 4, local[k].begin());
            if (k == 0) {
                places[k] = root;
                world[k] = local[k];
                continue;
            }
            Vector arm;
            turn(world[above[k]].data(), offsets[k].data(), arm.data());
            for (int n = 0; n < 3; ++n) places[k][n] = places[above[k]][n] + arm[n];
            multiply(world[above[k]].data(), local[k].data(), world[k].data());
        }
        return nb::make_tuple(listed(local), listed(places), listed(world));
    }

  private:
    template <class Values>
    static nb::list listed(const std::vector<Values> &values) {
        nb::list out;
        for (const Values &one : values) out.append(plain(one));
        return out;
    }

    std::vector<std::size_t> joints, above;
    std::vector<Vector> offsets;
};

struct Given {
    double seconds, brake, soft, straightest, backward;
};

struct Gently {
    double most;
    bool begun = false;
    Vector aim{}, at{}, velocity{};

    void follow(const double *to, const Given &given) {
        Vector before = aim;
        std::copy(to, to + 3, aim.begin());
        if (!begun) {
            begun = true;
            at = aim;
            return;
        }
        const double dt = given.seconds, leap = most * dt;
        Vector behind, change;
        for (int n = 0; n < 3; ++n) behind[n] = before[n] - at[n];
        const double far = length(behind.data()), braked = given.brake * most, brake = 0.5 * dt * braked;
        const double speed = std::min(far / dt, std::sqrt(brake * brake + 2.0 * braked * far) - brake);
        const double closer = far > 1e-12 ? speed / far : 0.0;
        for (int n = 0; n < 3; ++n) change[n] = (aim[n] - before[n]) / dt + closer * behind[n] - velocity[n];
        const double asked = length(change.data()), share = asked > leap ? leap / asked : 1.0;
        for (int n = 0; n < 3; ++n) {
            velocity[n] += share * change[n];
            at[n] += velocity[n] * dt;
        }
    }
};

struct Limb {
    std::size_t at, above;
    Range range;
    Gently turned;

    // Returns whether it was held back.
    bool inside(const double *q, double *to) const {
        double from[4], v[3];
        undo(range.middle.data(), q, from);
        logarithm(from, v);
        if (!range.hold(v)) {
            std::copy(q, q + 4, to);
            return false;
        }
        exponential(v, from);
        multiply(range.middle.data(), from, to);
        return true;
    }

    void toward(const double *own, const double *wanted, const Given &given, double *to) {
        double q[4], between[4], vector[3];
        inside(wanted, q);
        undo(own, q, between);
        logarithm(between, vector);
        turned.follow(vector, given);
        exponential(turned.at.data(), between);
        multiply(own, between, q);
        inside(q, to);
    }
};

// The least rotation from direction a to direction b.
void least_turn(const double *a, const double *b, double *to) {
    to[0] = 1.0, to[1] = to[2] = to[3] = 0.0;
    const double by_a = length(a), by_b = length(b);
    if (by_a < 1e-12 || by_b < 1e-12) return;
    double one[3], halfway[3], vector[3];
    for (int n = 0; n < 3; ++n) one[n] = a[n] / by_a, halfway[n] = one[n] + b[n] / by_b;
    const double size = length(halfway);
    if (size < 2e-9) return;
    cross(one, halfway, vector);
    to[0] = 0.5 * size;
    for (int n = 0; n < 3; ++n) to[n + 1] = vector[n] / size;
}

// after · before⁻¹
void between(const double *before, const double *after, double *to) {
    const double back[4] = {before[0], -before[1], -before[2], -before[3]};
    multiply(after, back, to);
}

class Leg {
  public:
    Leg(const Ranges &ranges, const std::array<std::size_t, 3> &joints, const std::array<std::size_t, 3> &at,
        const std::array<std::size_t, 3> &above, const std::array<double, 3> &most, const Vector &hinge, double seconds,
        double brake, double soft, double straightest, double backward)
        : hinge(hinge), given{seconds, brake, soft, straightest, backward} {
        for (int n = 0; n < 3; ++n) {
            limbs[n] = {at[n], above[n], ranges.of.at(joints[n]), {most[n]}};
            last = std::max({last, at[n], above[n]});
        }
    }

    nb::tuple reach(const std::vector<Vector> &places, const std::vector<Quaternion> &world,
                    const std::vector<Quaternion> &local, const std::vector<Vector> &sole, const Vector &target,
                    const Vector &shift, double bears) {
        if (std::min({places.size(), world.size(), local.size()}) <= last || sole.empty())
            throw std::invalid_argument("kinesics._native.Leg: too few joints");
        Limb &hip = limbs[0], &knee = limbs[1], &ankle = limbs[2];
        Vector at, upper, lower, whole, aim, reachable = target;
        for (int n = 0; n < 3; ++n) {
            at[n] = places[hip.at][n] + shift[n];
            upper[n] = places[knee.at][n] - places[hip.at][n];
            lower[n] = places[ankle.at][n] - places[knee.at][n];
            whole[n] = upper[n] + lower[n];
            aim[n] = target[n] - at[n];
        }
        const double now = length(whole.data()), asked = length(aim.data());
        if (asked > now) {
            const double share = (now + bears * (asked - now)) / asked;
            for (int n = 0; n < 3; ++n) reachable[n] = at[n] + share * aim[n];
        }
        Vector axis;
        turn(world[knee.at].data(), hinge.data(), axis.data());
        Quaternion bend, wanted, bent, swing, swung, turned, above, hip_to, knee_to, ankle_to, tipped;
        bending(at, upper, lower, reachable, axis, bend);
        // a thigh at the end of its range goes no farther, and the knee takes the ankle as near as it can
        turn(bend.data(), lower.data(), whole.data());
        for (int n = 0; n < 3; ++n) whole[n] += upper[n], reachable[n] -= at[n];
        least_turn(whole.data(), reachable.data(), swing.data());
        multiply(swing.data(), world[hip.at].data(), turned.data());
        undo(world[hip.above].data(), turned.data(), wanted.data());
        if (hip.inside(wanted.data(), hip_to.data())) {
            multiply(world[hip.above].data(), hip_to.data(), turned.data());
            between(world[hip.at].data(), turned.data(), swung.data());
            pointing(upper, lower, reachable, axis, swung, bend);
        }
        multiply(bend.data(), world[knee.at].data(), turned.data());
        undo(world[knee.above].data(), turned.data(), wanted.data());
        knee.toward(local[knee.at].data(), wanted.data(), given, knee_to.data());
        multiply(world[knee.above].data(), knee_to.data(), turned.data());
        between(world[knee.at].data(), turned.data(), bent.data());
        turn(bent.data(), lower.data(), lower.data());
        for (int n = 0; n < 3; ++n) whole[n] = upper[n] + lower[n];
        least_turn(whole.data(), aim.data(), swing.data());
        multiply(swing.data(), world[hip.at].data(), turned.data());
        undo(world[hip.above].data(), turned.data(), wanted.data());
        hip.toward(local[hip.at].data(), wanted.data(), given, hip_to.data());
        multiply(world[hip.above].data(), hip_to.data(), turned.data());
        between(world[hip.at].data(), turned.data(), swung.data());
        multiply(swung.data(), bent.data(), bent.data());
        multiply(bent.data(), world[ankle.above].data(), above.data());
        undo(above.data(), world[ankle.at].data(), wanted.data());
        ankle.toward(local[ankle.at].data(), wanted.data(), given, ankle_to.data());
        multiply(above.data(), ankle_to.data(), turned.data());
        between(world[ankle.at].data(), turned.data(), tipped.data());
        turn(swung.data(), whole.data(), whole.data());
        Vector missed;
        for (int n = 0; n < 3; ++n) missed[n] = target[n] - (at[n] + whole[n]);
        double lowest = INFINITY;
        for (const Vector &point : sole) {
            Vector arm;
            for (int n = 0; n < 3; ++n) arm[n] = point[n] - places[ankle.at][n];
            turn(tipped.data(), arm.data(), arm.data());
            lowest = std::min(lowest, arm[1]);
        }
        return nb::make_tuple(plain(hip_to), plain(knee_to), plain(ankle_to), plain(missed), at[1] + whole[1] + lowest);
    }

  private:
    // The turn in the world of what hangs on the knee that brings the ankle as far from the hip as the target is.
    void bending(const Vector &at, const Vector &upper, const Vector &lower, const Vector &target, const Vector &axis,
                 Quaternion &to) const {
        Vector aim, whole, across;
        for (int n = 0; n < 3; ++n) aim[n] = target[n] - at[n], whole[n] = upper[n] + lower[n];
        const double l1 = length(upper.data()), l2 = length(lower.data());
        const double now = length(whole.data()), asked = length(aim.data());
        to = {1.0, 0.0, 0.0, 0.0};
        if (asked == now) return;
        const double most = given.straightest * (l1 + l2);
        const double start = std::min(std::max(now, given.soft * (l1 + l2)), most - 1e-9 * (l1 + l2)), room = most - start;
        double far = asked <= start ? asked : start - room * std::expm1(-(asked - start) / room);
        far = std::max(far, std::abs(l1 - l2) + 1e-4 * (l1 + l2));
        cross(axis.data(), lower.data(), across.data());
        const double scale = 1.0 / (l1 * l2), c = dot(axis.data(), upper.data()) * dot(axis.data(), lower.data()) * scale;
        const double a = dot(upper.data(), lower.data()) * scale - c, b = dot(upper.data(), across.data()) * scale;
        const double size = std::hypot(a, b), bent = -std::atan2(b, a);
        const double cosine = 0.5 * (far * far - l1 * l1 - l2 * l2) * scale - c;
        // where a bone lies along the hinge, turning about it changes nothing
        double angle = size > 1e-12 ? std::acos(std::min(std::max(cosine / size, -1.0), 1.0)) - std::abs(bent) : 0.0;
        if (bent < given.backward) angle = -angle;
        const double sine = std::sin(0.5 * angle);
        to = {std::cos(0.5 * angle), sine * axis[0], sine * axis[1], sine * axis[2]};
    }

    // The turn of the shank, the thigh being swung, by which it points as near to the target as its hinge lets it.
    static void pointing(const Vector &upper, const Vector &lower, const Vector &target, const Vector &axis,
                         const Quaternion &swung, Quaternion &to) {
        const Quaternion back = {swung[0], -swung[1], -swung[2], -swung[3]};
        Vector way, across;
        turn(back.data(), target.data(), way.data());
        for (int n = 0; n < 3; ++n) way[n] -= upper[n];
        cross(lower.data(), way.data(), across.data());
        const double along = dot(lower.data(), way.data()) - dot(axis.data(), lower.data()) * dot(axis.data(), way.data());
        const double half = 0.5 * std::atan2(dot(axis.data(), across.data()), along), sine = std::sin(half);
        to = {std::cos(half), sine * axis[0], sine * axis[1], sine * axis[2]};
    }

    std::array<Limb, 3> limbs;
    std::size_t last = 0;
    Vector hinge;
    Given given;
};

}  // namespace

void bind_live(nb::module_ &m) {
    m.def("blended", &blended, "rotations"_a.noconvert(), "offset"_a.noconvert(), "velocity"_a.noconvert(),
          "before"_a.noconvert(), "after"_a.noconvert(), "share"_a.noconvert(), "time"_a);
    nb::class_<Chain>(m, "Chain")
        .def(nb::init<std::vector<std::size_t>, std::vector<std::size_t>, std::vector<Vector>>(), "joints"_a, "above"_a,
             "offsets"_a)
        .def("placed", &Chain::placed, "rotations"_a.noconvert(), "root"_a);
    nb::class_<Leg>(m, "Leg")
        .def(nb::init<const Ranges &, const std::array<std::size_t, 3> &, const std::array<std::size_t, 3> &,
                      const std::array<std::size_t, 3> &, const std::array<double, 3> &, const Vector &, double, double, double,
                      double, double>(),
             "ranges"_a, "joints"_a, "at"_a, "above"_a, "most"_a, "hinge"_a, "seconds"_a, "brake"_a, "soft"_a,
             "straightest"_a, "backward"_a)
        .def("reach", &Leg::reach, "places"_a, "world"_a, "local"_a, "sole"_a, "target"_a, "shift"_a, "bears"_a);
}
