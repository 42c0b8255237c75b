// One quaternion (w, x, y, z), one vector, as plain numbers: what several kernels do with them.
#pragma once

#include <algorithm>
#include <cmath>

namespace kinesics {

inline void multiply(const double *a, const double *b, double *to) {
    const double aw = a[0], ax = a[1], ay = a[2], az = a[3], bw = b[0], bx = b[1], by = b[2], bz = b[3];
    to[0] = aw * bw - ax * bx - ay * by - az * bz;
    to[1] = aw * bx + ax * bw + ay * bz - az * by;
    to[2] = aw * by - ax * bz + ay * bw + az * bx;
    to[3] = aw * bz + ax * by - ay * bx + az * bw;
}

// conjugate(a) b
inline void undo(const double *a, const double *b, double *to) {
    const double inverse[4] = {a[0], -a[1], -a[2], -a[3]};
    multiply(inverse, b, to);
}

// v + 2 w u x v + 2 u x (u x v)
inline void turn(const double *q, const double *v, double *to) {
    const double vx = v[0], vy = v[1], vz = v[2];
    const double x = 2.0 * (q[2] * vz - q[3] * vy), y = 2.0 * (q[3] * vx - q[1] * vz), z = 2.0 * (q[1] * vy - q[2] * vx);
    to[0] = vx + q[0] * x + (q[2] * z - q[3] * y);
    to[1] = vy + q[0] * y + (q[3] * x - q[1] * z);
    to[2] = vz + q[0] * z + (q[1] * y - q[2] * x);
}

inline double dot(const double *a, const double *b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

inline double length(const double *v) { return std::sqrt(dot(v, v)); }

inline void cross(const double *a, const double *b, double *to) {
    const double x = a[1] * b[2] - a[2] * b[1], y = a[2] * b[0] - a[0] * b[2], z = a[0] * b[1] - a[1] * b[0];
    to[0] = x;
    to[1] = y;
    to[2] = z;
}

// A rotation vector of at most half a turn.
inline void logarithm(const double *q, double *to) {
    const double sine = length(q + 1);
    // angle / sin(angle / 2) goes to 2
    double scale = sine > 1e-150 ? 2.0 * std::atan2(sine, std::abs(q[0])) / sine : 2.0;
    if (q[0] < 0.0) scale = -scale;
    for (int n = 0; n < 3; ++n) to[n] = scale * q[n + 1];
}

inline void exponential(const double *v, double *to) {
    const double angle = length(v), half = 0.5 * angle;
    // sin(angle / 2) / angle goes to 1/2
    const double scale = angle > 1e-150 ? std::sin(half) / angle : 0.5;
    to[0] = std::cos(half);
    for (int n = 0; n < 3; ++n) to[n + 1] = scale * v[n];
}

// What is left of an offset and its velocity so many seconds from a cut: kinesics/synthesis/embodiment/blending.py, two_sided.
struct Passing {
    double of_offset, of_velocity;

    Passing(double before, double after, double share, double time) {
        const bool early = time < 0.0;
        const double span = early ? before : after, way = early ? -span : span, part = early ? share : share - 1.0;
        const double t = std::min(std::abs(time) / span, 1.0), rest = 1.0 - t, cube = part * rest * rest * rest;
        of_offset = cube * (1.0 + t * (3.0 + 6.0 * t));
        of_velocity = cube * way * t * (1.0 + 3.0 * t);
    }

    void add(const double *offset, const double *velocity, double *to) const {
        for (int n = 0; n < 3; ++n) to[n] = of_offset * offset[n] + of_velocity * velocity[n];
    }
};

}  // namespace kinesics
