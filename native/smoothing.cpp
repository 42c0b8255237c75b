// A smooth curve above another. The NumPy twin is in kinesics/synthesis/embodiment/planting.py.
#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>

#include <algorithm>
#include <cstdint>
#include <stdexcept>
#include <vector>

namespace nb = nanobind;
using namespace nb::literals;

namespace {

using In = nb::ndarray<const double, nb::shape<-1>, nb::c_contig, nb::device::cpu>;
using Out = nb::ndarray<double, nb::shape<-1>, nb::c_contig, nb::device::cpu>;

// out: the greatest of `values` within half a window, averaged under the window; values beyond the ends are those at the ends.
// `values` are not negative; over long stretches they are 0, where there is nothing to do.
void envelope(In values, In window, Out out) {
    const auto frames = std::int64_t(values.shape(0)), width = std::int64_t(window.shape(0)), reach = width / 2;
    if (width % 2 != 1 || std::int64_t(out.shape(0)) != frames)
        throw std::invalid_argument("kinesics._native.envelope: shapes do not fit");
    const double *given = values.data(), *weights = window.data();
    double *to = out.data();
    nb::gil_scoped_release release;
    // with half a window more at either end
    std::vector<double> wide(std::size_t(frames + 2 * reach), 0.0);
    double *const middle = wide.data() + reach;
    for (std::int64_t i = 0; i < frames; ++i)
        if (given[i] != 0.0)
            for (std::int64_t j = std::max<std::int64_t>(0, i - reach); j <= std::min(frames - 1, i + reach); ++j)
                middle[j] = std::max(middle[j], given[i]);
    if (frames > 0) {
        std::fill(wide.data(), middle, middle[0]);
        std::fill(middle + frames, middle + frames + reach, middle[frames - 1]);
    }
    std::int64_t last = -1;  // of what is not 0 in `wide`
    for (std::int64_t k = 0; k < 2 * reach; ++k)
        if (wide[std::size_t(k)] != 0.0) last = k;
    for (std::int64_t i = 0; i < frames; ++i) {
        const double *from = wide.data() + i;
        if (from[2 * reach] != 0.0) last = i + 2 * reach;
        double sum = 0.0;
        if (last >= i)
            for (std::int64_t k = 0; k < width; ++k) sum += weights[k] * from[k];
        to[i] = sum;
    }
}

}  // namespace

void bind_smoothing(nb::module_ &m) {
    m.def("envelope", &envelope, "values"_a.noconvert(), "window"_a.noconvert(), "out"_a.noconvert());
}
