// One quaternion (w, x, y, z), one vector, as plain numbers: what several kernels do with them.
#pragma once

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

}  // namespace kinesics
