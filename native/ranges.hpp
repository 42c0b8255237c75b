// How far a joint goes: each component of its rotation vector, and the angles between its bones and the one before.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "quaternion.hpp"

namespace kinesics {

struct Bend {
    // Directions of the bone before, in the frame of the mean rotation, and of the joint's own, in its own frame.
    std::array<double, 3> along, own;
    double least, most;
};

struct Range {
    static constexpr double rounding = 1e-9, level = 1e-6;
    static constexpr int steps = 16, halvings = 40;

    std::array<double, 4> middle;
    std::array<double, 3> low, high, inner;
    std::vector<Bend> bends;

    // Where a rotation is, as a vector from the mean.
    const Range &seen(const double *own, double *v) const {
        double from[4];
        undo(middle.data(), own, from);
        logarithm(from, v);
        return *this;
    }

    // The rotation that is there.
    void put(const double *v, double *own) const {
        double from[4];
        exponential(v, from);
        multiply(middle.data(), from, own);
    }

    // Rotation vector from the mean, moved to within the range; returns whether it was beyond.
    bool hold(double *v) const {
        double off = 0.0;
        for (int n = 0; n < 3; ++n) {
            const double held = std::min(std::max(v[n], low[n]), high[n]);
            off += std::abs(held - v[n]);
            v[n] = held;
        }
        if (bends.empty()) return off >= rounding;
        double slope[3];
        for (int step = 0; step < steps; ++step) {
            const double over = worst(v, slope);
            if (std::abs(over) <= rounding) return step > 0 || off >= rounding;
            double size = 0.0;
            for (int n = 0; n < 3; ++n) {
                const double goes = -over * slope[n];
                if ((goes > 0.0 && v[n] >= high[n]) || (goes < 0.0 && v[n] <= low[n])) slope[n] = 0.0;
                size += slope[n] * slope[n];
            }
            if (size < level) break;
            for (int n = 0; n < 3; ++n) v[n] = std::min(std::max(v[n] - over / size * slope[n], low[n]), high[n]);
        }
        if (std::abs(worst(v, slope)) > rounding) inwards(v);
        return true;
    }

  private:
    // Radians by which the angle that is farthest beyond its ends is: positive if too large; and how it goes with v.
    double worst(const double *v, double *slope) const {
        double q[4], over = 0.0;
        exponential(v, q);
        for (const Bend &bend : bends) {
            double points[3], across[3];
            turn(q, bend.own.data(), points);
            cross(bend.along.data(), points, across);
            const double sine = length(across), angle = std::atan2(sine, dot(bend.along.data(), points));
            const double by = angle > bend.most ? angle - bend.most : std::min(angle - bend.least, 0.0);
            if (std::abs(by) <= std::abs(over)) continue;
            over = by;
            const double back[4] = {q[0], -q[1], -q[2], -q[3]};
            double along[3], about[3], once[3], twice[3];
            turn(back, bend.along.data(), along);
            cross(along, bend.own.data(), about);
            const double scale = sine > 1e-12 ? 1.0 / sine : 0.0;
            for (double &n : about) n *= scale;
            const double square = dot(v, v), size = std::sqrt(square);
            const double first = size > 1e-3 ? (1.0 - std::cos(size)) / square : 0.5;
            const double second = size > 1e-3 ? (size - std::sin(size)) / (square * size) : 1.0 / 6.0;
            cross(v, about, once);
            cross(v, once, twice);
            for (int n = 0; n < 3; ++n) slope[n] = about[n] + first * once[n] + second * twice[n];
        }
        return over;
    }

    // Where no way along the slope leads into the range, towards what is well within.
    void inwards(double *v) const {
        double good = 1.0, bad = 0.0, at[3], slope[3];
        for (int n = 0; n < halvings; ++n) {
            const double share = 0.5 * (good + bad);
            for (int k = 0; k < 3; ++k) at[k] = v[k] + share * (inner[k] - v[k]);
            (std::abs(worst(at, slope)) > rounding ? bad : good) = share;
        }
        for (int k = 0; k < 3; ++k) v[k] += good * (inner[k] - v[k]);
    }
};

// Of all joints of a body.
struct Ranges {
    std::vector<Range> of;
};

}  // namespace kinesics
