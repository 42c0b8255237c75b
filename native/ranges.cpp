// Joints held in their ranges. The NumPy twin is in kinesics/synthesis/embodiment/ranges.py.
#include "ranges.hpp"

#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/vector.h>

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

// Rotations from joint `first` on, in place.
void hold(const Ranges &ranges, Rotations rotations, std::size_t first) {
    if (rotations.shape(0) != ranges.of.size()) throw std::invalid_argument("kinesics._native.Ranges: shapes do not fit");
    for (std::size_t j = first; j < ranges.of.size(); ++j) {
        double *own = rotations.data() + 4 * j;
        double from[4], vector[3];
        kinesics::undo(ranges.of[j].middle.data(), own, from);
        kinesics::logarithm(from, vector);
        if (!ranges.of[j].hold(vector)) continue;
        kinesics::exponential(vector, from);
        kinesics::multiply(ranges.of[j].middle.data(), from, own);
    }
}

}  // namespace

void bind_ranges(nb::module_ &m) {
    nb::class_<Ranges>(m, "Ranges")
        .def("__init__", &make, "middle"_a.noconvert(), "low"_a.noconvert(), "high"_a.noconvert(), "inner"_a.noconvert(),
             "bent"_a, "bends"_a.noconvert())
        .def("within", &within, "joint"_a, "vectors"_a.noconvert())
        .def("hold", &hold, "rotations"_a.noconvert(), "first"_a);
}
