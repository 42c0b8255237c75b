// Paths of recurrence by dynamic programming: along one lag, and at right angles to the identity axis.
// The NumPy twins are in kinesics/grammar/lags.py; ties go to the same side there and here.
#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>

#include <cstdint>
#include <limits>
#include <stdexcept>
#include <utility>
#include <vector>

namespace nb = nanobind;
using namespace nb::literals;

namespace {

using Rows = nb::ndarray<const float, nb::shape<-1, -1>, nb::c_contig, nb::device::cpu>;
using Path = nb::ndarray<std::int64_t, nb::shape<-1>, nb::c_contig, nb::device::cpu>;
using Costs = nb::ndarray<double, nb::shape<-1>, nb::c_contig, nb::device::cpu>;

constexpr double kInf = std::numeric_limits<double>::infinity();

// rows(k, t): the cheapest path over t in [0, length), k in [low, low + width), at most one row up or down a step.
void cheapest_path(Rows rows, std::int64_t low, std::int64_t width, double bend, Path out) {
    const std::int64_t stride = static_cast<std::int64_t>(rows.shape(1));
    const std::int64_t length = static_cast<std::int64_t>(out.shape(0));
    if (low < 0 || width < 1 || low + width > static_cast<std::int64_t>(rows.shape(0)) || length < 1 || length > stride)
        throw std::invalid_argument("cheapest_path: the band does not lie within the rows");
    const float *cells = rows.data() + low * stride;
    std::int64_t *path = out.data();
    nb::gil_scoped_release released;
    // gathered by moment: a pass over time then reads memory in order
    constexpr std::int64_t kBlock = 64;
    std::vector<float> block(static_cast<std::size_t>(kBlock * width));
    std::vector<double> total(static_cast<std::size_t>(width) + 2, kInf), next(total);
    std::vector<std::int8_t> came(static_cast<std::size_t>(length * width));
    for (std::int64_t start = 0; start < length; start += kBlock) {
        const std::int64_t stop = start + kBlock < length ? start + kBlock : length;
        for (std::int64_t k = 0; k < width; ++k)
            for (std::int64_t t = start; t < stop; ++t)
                block[static_cast<std::size_t>((t - start) * width + k)] = cells[k * stride + t];
        for (std::int64_t t = start; t < stop; ++t) {
            const float *here = block.data() + (t - start) * width;
            std::int8_t *from = came.data() + t * width;
            for (std::int64_t k = 0; k < width; ++k) {
                const double stay = t == 0 ? 0.0 : total[static_cast<std::size_t>(k + 1)];
                const double below = t == 0 ? kInf : total[static_cast<std::size_t>(k)] + bend;
                const double above = t == 0 ? kInf : total[static_cast<std::size_t>(k + 2)] + bend;
                double best = stay;
                std::int8_t step = 0;
                if (below < best) best = below, step = -1;
                if (above < best) best = above, step = 1;
                from[k] = step;
                next[static_cast<std::size_t>(k + 1)] = static_cast<double>(here[k]) + best;
            }
            std::swap(total, next);
        }
    }
    std::int64_t k = 0;
    for (std::int64_t other = 1; other < width; ++other)
        if (total[static_cast<std::size_t>(other + 1)] < total[static_cast<std::size_t>(k + 1)]) k = other;
    for (std::int64_t t = length - 1; t >= 0; --t) {
        path[t] = k;
        k += came[static_cast<std::size_t>(t * width + k)];
    }
}

// rows(k, i): distance of moments i and i + k. costs(c): mean along the cheapest path outwards from place c / 2.
void turning_costs(Rows rows, std::int64_t reach, double bend, Costs out) {
    const std::int64_t lags = static_cast<std::int64_t>(rows.shape(0)), n = static_cast<std::int64_t>(rows.shape(1));
    const std::int64_t places = 2 * n - 1;
    if (n < 1 || reach < 1 || static_cast<std::int64_t>(out.shape(0)) != places)
        throw std::invalid_argument("turning_costs: one cost for each place");
    const float *cells = rows.data();
    double *costs = out.data();
    nb::gil_scoped_release released;
    struct Front {
        std::vector<double> total;
        std::vector<std::int64_t> origin;
    };
    const auto fresh = [&] {
        Front f{std::vector<double>(static_cast<std::size_t>(places), kInf),
                std::vector<std::int64_t>(static_cast<std::size_t>(places))};
        for (std::int64_t c = 0; c < places; ++c) f.origin[static_cast<std::size_t>(c)] = c;
        return f;
    };
    const auto cell = [&](std::int64_t span, std::int64_t c) -> double {
        if (span >= lags || (c - span) % 2 != 0) return kInf;
        const std::int64_t i = (c - span) / 2;
        return i >= 0 && i + span < n ? static_cast<double>(cells[span * n + i]) : kInf;
    };
    Front before = fresh(), last = fresh(), next = fresh();
    for (std::int64_t c = 0; c < places; ++c) {
        before.total[static_cast<std::size_t>(c)] = cell(0, c);
        last.total[static_cast<std::size_t>(c)] = cell(1, c);
    }
    for (std::int64_t span = 2; span <= 2 * reach; ++span) {
        for (std::int64_t c = 0; c < places; ++c) {
            const std::size_t at = static_cast<std::size_t>(c);
            const double here = cell(span, c);
            double best = before.total[at] + 2.0 * here;
            std::int64_t from = before.origin[at];
            const double left = c > 0 ? last.total[at - 1] + here + bend : kInf;
            if (left < best) best = left, from = last.origin[at - 1];
            const double right = c + 1 < places ? last.total[at + 1] + here + bend : kInf;
            if (right < best) best = right, from = last.origin[at + 1];
            next.total[at] = best;
            next.origin[at] = from;
        }
        std::swap(before, last);
        std::swap(last, next);
    }
    const double cells_on_path = static_cast<double>(2 * reach + 1);
    for (std::int64_t c = 0; c < places; ++c) costs[c] = kInf;
    for (const Front *front : {&before, &last})
        for (std::int64_t c = 0; c < places; ++c) {
            const double mean = front->total[static_cast<std::size_t>(c)] / cells_on_path;
            double &best = costs[front->origin[static_cast<std::size_t>(c)]];
            if (mean < best) best = mean;
        }
}

}  // namespace

void bind_paths(nb::module_ &m) {
    m.def("cheapest_path", &cheapest_path, "rows"_a.noconvert(), "low"_a, "width"_a, "bend"_a, "out"_a.noconvert());
    m.def("turning_costs", &turning_costs, "rows"_a.noconvert(), "reach"_a, "bend"_a, "out"_a.noconvert());
}
