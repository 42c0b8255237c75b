// Products, turned vectors, logarithms and exponentials of many quaternions. The NumPy twins are in kinesics/geometry/quaternion.py.
#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>

#include <cmath>
#include <cstdint>
#include <initializer_list>
#include <stdexcept>
#include <utility>

#include "quaternion.hpp"

namespace nb = nanobind;
using namespace nb::literals;
using kinesics::exponential;
using kinesics::length;
using kinesics::logarithm;
using kinesics::multiply;
using kinesics::undo;

namespace {

// Any strides: columns picked from larger arrays, and 0 where one is repeated.
using In = nb::ndarray<const double, nb::shape<-1, -1, -1>, nb::device::cpu>;
using Out = nb::ndarray<double, nb::shape<-1, -1, -1>, nb::c_contig, nb::device::cpu>;

struct Rows {
    const double *data;
    std::int64_t outer, inner, step;

    explicit Rows(const In &array) : data(array.data()), outer(array.stride(0)), inner(array.stride(1)), step(array.stride(2)) {}

    template <int Width>
    void take(std::int64_t i, std::int64_t j, double (&to)[Width]) const {
        const double *at = data + i * outer + j * inner;
        for (int n = 0; n < Width; ++n) to[n] = at[n * step];
    }
};

void check(const Out &out, std::size_t width, std::initializer_list<std::pair<const In *, std::size_t>> inputs) {
    bool good = out.shape(2) == width;
    for (const auto &[array, its] : inputs)
        good = good && array->shape(0) == out.shape(0) && array->shape(1) == out.shape(1) && array->shape(2) == its;
    if (!good) throw std::invalid_argument("kinesics._native: shapes of quaternions do not fit");
}

// each(i, j, to) for every row of the output
template <class Each>
void for_rows(const Out &out, const Each &each) {
    const auto outer = std::int64_t(out.shape(0)), inner = std::int64_t(out.shape(1)), width = std::int64_t(out.shape(2));
    double *to = out.data();
    nb::gil_scoped_release release;
    for (std::int64_t i = 0; i < outer; ++i)
        for (std::int64_t j = 0; j < inner; ++j, to += width) each(i, j, to);
}

// each(p, q, to) for every pair of rows of two inputs
template <int WidthA, int WidthB, class Each>
void for_pairs(const In &a, const In &b, const Out &out, std::size_t width, const Each &each) {
    check(out, width, {{&a, WidthA}, {&b, WidthB}});
    const Rows first(a), second(b);
    for_rows(out, [&](std::int64_t i, std::int64_t j, double *to) {
        double p[WidthA], q[WidthB];
        first.take(i, j, p);
        second.take(i, j, q);
        each(p, q, to);
    });
}

void quaternion_products(In a, In b, Out out) {
    for_pairs<4, 4>(a, b, out, 4, [](const double *p, const double *q, double *to) { multiply(p, q, to); });
}

void quaternion_offsets(In a, In b, Out out) {
    for_pairs<4, 4>(a, b, out, 3, [](const double *p, const double *q, double *to) {
        double between[4];
        undo(p, q, between);
        logarithm(between, to);
    });
}

void quaternion_angles(In a, In b, Out out) {
    for_pairs<4, 4>(a, b, out, 1, [](const double *p, const double *q, double *to) {
        double between[4];
        undo(p, q, between);
        *to = 2.0 * std::atan2(length(between + 1), std::abs(between[0]));
    });
}

void quaternion_logarithms(In a, Out out) {
    check(out, 3, {{&a, 4}});
    const Rows rows(a);
    for_rows(out, [&](std::int64_t i, std::int64_t j, double *to) {
        double q[4];
        rows.take(i, j, q);
        logarithm(q, to);
    });
}

void quaternion_exponentials(In a, Out out) {
    check(out, 4, {{&a, 3}});
    const Rows rows(a);
    for_rows(out, [&](std::int64_t i, std::int64_t j, double *to) {
        double v[3];
        rows.take(i, j, v);
        exponential(v, to);
    });
}

void quaternion_turned(In a, In b, Out out) {
    for_pairs<4, 3>(a, b, out, 3, [](const double *q, const double *v, double *to) { kinesics::turn(q, v, to); });
}

}  // namespace

void bind_quaternions(nb::module_ &m) {
    m.def("quaternion_products", &quaternion_products, "a"_a.noconvert(), "b"_a.noconvert(), "out"_a.noconvert());
    m.def("quaternion_offsets", &quaternion_offsets, "a"_a.noconvert(), "b"_a.noconvert(), "out"_a.noconvert());
    m.def("quaternion_angles", &quaternion_angles, "a"_a.noconvert(), "b"_a.noconvert(), "out"_a.noconvert());
    m.def("quaternion_logarithms", &quaternion_logarithms, "a"_a.noconvert(), "out"_a.noconvert());
    m.def("quaternion_exponentials", &quaternion_exponentials, "a"_a.noconvert(), "out"_a.noconvert());
    m.def("quaternion_turned", &quaternion_turned, "a"_a.noconvert(), "b"_a.noconvert(), "out"_a.noconvert());
}
