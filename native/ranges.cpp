// Joints held in their ranges. The NumPy twin is in kinesics/synthesis/embodiment/ranges.py.
#include "ranges.hpp"

#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/vector.h>

#include <algorithm>
#include <cstddef>
#include <new>
#include <stdexcept>
#include <vector>

namespace nb = nanobind;
using namespace nb::literals;
using kinesics::Range;
using kinesics::Ranges;

namespace {

using Rotations = nb::ndarray<double, nb::shape<-1, 4>, nb::c_contig, nb::device::cpu>;
using Places = nb::ndarray<double, nb::shape<-1, 3>, nb::c_contig, nb::device::cpu>;
using Quaternions = nb::ndarray<const double, nb::shape<-1, 4>, nb::c_contig, nb::device::cpu>;
using Vectors = nb::ndarray<const double, nb::shape<-1, 3>, nb::c_contig, nb::device::cpu>;
using Stretch = nb::ndarray<const double, nb::shape<-1, -1, 3>, nb::c_contig, nb::device::cpu>;
using Weights = nb::ndarray<const double, nb::shape<-1>, nb::c_contig, nb::device::cpu>;
using Angles = nb::ndarray<const double, nb::shape<-1, 8>, nb::c_contig, nb::device::cpu>;

// bends: directions of the bone before and of the joint's own, least and greatest angle between them; bent: their joints.
void make(Ranges *ranges, Quaternions middle, Vectors low, Vectors high, Vectors inner, const std::vector<std::size_t> &bent,
          Angles bends) {
    const auto joints = middle.shape(0);
    bool good = low.shape(0) == joints && high.shape(0) == joints && inner.shape(0) == joints && bends.shape(0) == bent.size();
    for (const std::size_t joint : bent) good = good && joint < joints;
    if (!good) throw std::invalid_argument("kinesics._native.Ranges: shapes do not fit");
    new (ranges) Ranges{std::vector<Range>(joints)};
    for (std::size_t j = 0; j < joints; ++j) {
        Range &range = ranges->of[j];
        std::copy_n(middle.data() + 4 * j, 4, range.middle.begin());
        std::copy_n(low.data() + 3 * j, 3, range.low.begin());
        std::copy_n(high.data() + 3 * j, 3, range.high.begin());
        std::copy_n(inner.data() + 3 * j, 3, range.inner.begin());
    }
    for (std::size_t k = 0; k < bent.size(); ++k) {
        const double *row = bends.data() + 8 * k;
        ranges->of[bent[k]].bends.push_back({{row[0], row[1], row[2]}, {row[3], row[4], row[5]}, row[6], row[7]});
    }
}

// Rotation vectors of one joint from its mean, in place.
void within(const Ranges &ranges, std::size_t joint, Places vectors) {
    if (joint >= ranges.of.size()) throw std::invalid_argument("kinesics._native.Ranges: no such joint");
    const Range &range = ranges.of[joint];
    double *at = vectors.data();
    const auto count = vectors.shape(0);
    nb::gil_scoped_release release;
    for (std::size_t k = 0; k < count; ++k) range.hold(at + 3 * k);
}

// Rotations from joint `first` on, in place; where `back` is given each is turned back first, by a rotation vector in the frame of
// its mean.
void hold_all(const Ranges &ranges, Rotations rotations, std::size_t first, const double *back) {
    if (rotations.shape(0) != ranges.of.size()) throw std::invalid_argument("kinesics._native.Ranges: shapes do not fit");
    for (std::size_t j = first; j < ranges.of.size(); ++j) {
        double vector[3];
        const Range &range = ranges.of[j].seen(rotations.data() + 4 * j, vector);
        bool turned = false;
        for (int n = 0; back != nullptr && n < 3; ++n) {
            vector[n] -= back[3 * j + n];
            turned = turned || back[3 * j + n] != 0.0;
        }
        if (range.hold(vector) || turned) range.put(vector, rotations.data() + 4 * j);
    }
}

void hold(const Ranges &ranges, Rotations rotations, std::size_t first) { hold_all(ranges, rotations, first, nullptr); }

void hold_back(const Ranges &ranges, Rotations rotations, std::size_t first, Vectors back) {
    if (back.shape(0) != ranges.of.size()) throw std::invalid_argument("kinesics._native.Ranges: shapes do not fit");
    hold_all(ranges, rotations, first, back.data());
}

// Rotation vectors by which joints from `first` on are beyond; returns whether any is.
bool excess(const Ranges &ranges, Quaternions rotations, std::size_t first, Places out) {
    if (rotations.shape(0) != ranges.of.size() || out.shape(0) != ranges.of.size())
        throw std::invalid_argument("kinesics._native.Ranges: shapes do not fit");
    std::fill_n(out.data(), 3 * ranges.of.size(), 0.0);
    bool any = false;
    for (std::size_t j = first; j < ranges.of.size(); ++j) {
        double vector[3], held[3];
        const Range &range = ranges.of[j].seen(rotations.data() + 4 * j, vector);
        std::copy_n(vector, 3, held);
        if (!range.hold(held)) continue;
        any = true;
        for (int n = 0; n < 3; ++n) out.data()[3 * j + n] = vector[n] - held[n];
    }
    return any;
}

// The middle of the smooth curve that is nowhere less than what joints are beyond in 2n − 1 frames, to either side, under a window
// of n: kinesics.synthesis.embodiment.ranges.both_ways.
void eased(Stretch beyond, Weights window, Places out) {
    const std::size_t size = window.shape(0), joints = beyond.shape(1), columns = 3 * joints;
    if (size == 0 || beyond.shape(0) != 2 * size - 1 || out.shape(0) != joints)
        throw std::invalid_argument("kinesics._native.eased: shapes do not fit");
    for (std::size_t c = 0; c < columns; ++c) {
        const double *values = beyond.data() + c;
        double sum = 0.0;
        bool any = false;
        for (std::size_t k = 0; k < 2 * size - 1; ++k) any = any || values[k * columns] != 0.0;
        for (std::size_t k = 0; any && k < size; ++k) {
            double over = 0.0, under = 0.0;
            for (std::size_t n = k; n < k + size; ++n) {
                over = std::max(over, values[n * columns]);
                under = std::min(under, values[n * columns]);
            }
            sum += window.data()[k] * (over + under);
        }
        out.data()[c] = sum;
    }
}

}  // namespace

void bind_ranges(nb::module_ &m) {
    m.def("eased", &eased, "beyond"_a.noconvert(), "window"_a.noconvert(), "out"_a.noconvert());
    nb::class_<Ranges>(m, "Ranges")
        .def("__init__", &make, "middle"_a.noconvert(), "low"_a.noconvert(), "high"_a.noconvert(), "inner"_a.noconvert(),
             "bent"_a, "bends"_a.noconvert())
        .def("within", &within, "joint"_a, "vectors"_a.noconvert())
        .def("hold", &hold, "rotations"_a.noconvert(), "first"_a)
        .def("hold_back", &hold_back, "rotations"_a.noconvert(), "first"_a, "back"_a.noconvert())
        .def("excess", &excess, "rotations"_a.noconvert(), "first"_a, "out"_a.noconvert());
}
