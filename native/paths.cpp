// Paths by dynamic programming: along one lag, at right angles to the identity axis, and of a stretch looked up elsewhere.
// The NumPy twins are in kinesics/grammar (lags.py, motifs/, evidence.py, reading/); ties go to the same side there and here.
#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/pair.h>

#include <algorithm>
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
using Blocks = nb::ndarray<const float, nb::shape<-1, -1, -1>, nb::c_contig, nb::device::cpu>;
using Weights = nb::ndarray<const double, nb::shape<-1>, nb::c_contig, nb::device::cpu>;
using FloatCosts = nb::ndarray<float, nb::shape<-1>, nb::c_contig, nb::device::cpu>;
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

// What comes before the middle row (or after it) on the cheapest way there, for the columns [first, last) of the result: `half`
// rows, each step one row and none, one or two columns further in the direction `towards`. The result is left in `run`.
void seed_side(const float *middle, std::int64_t row_step, std::int64_t n, std::int64_t half, std::int64_t towards, float bend,
               std::int64_t first, std::int64_t last, std::vector<float> &run, std::vector<float> &next) {
    // a block of columns with what its paths may come from: the whole of it stays in the first cache
    const std::int64_t low = towards > 0 ? first : std::max<std::int64_t>(0, first - 2 * half);
    const std::int64_t high = towards > 0 ? std::min(n, last + 2 * half) : last;
    const std::int64_t width = high - low;
    constexpr float kFar = std::numeric_limits<float>::infinity();
    std::fill(run.begin(), run.begin() + width, 0.f);
    for (std::int64_t s = half; s > 0; --s) {
        const float *row = middle + s * row_step + low;
        float *r = run.data(), *b = next.data();
        for (std::int64_t j = 0; j < width; ++j) r[j] += row[j];
        for (std::int64_t j = 0; j < width; ++j) b[j] = r[j] + bend;
        if (towards > 0) {
            for (std::int64_t j = 0; j + 1 < width; ++j) b[j] = std::min(b[j], r[j + 1]);
            for (std::int64_t j = 0; j + 2 < width; ++j) b[j] = std::min(b[j], r[j + 2] + bend);
            if (high == n) b[width - 1] = kFar;
        } else {
            for (std::int64_t j = 1; j < width; ++j) b[j] = std::min(b[j], r[j - 1]);
            for (std::int64_t j = 2; j < width; ++j) b[j] = std::min(b[j], r[j - 2] + bend);
            if (low == 0) b[0] = kFar;
        }
        std::swap(run, next);
    }
}

// rows: an odd number of them. costs(j): mean along the cheapest path of all rows that passes column j in the middle row, of the
// halves before and after it the worse one.
void seed_costs(Rows rows, double bend, bool backwards, FloatCosts out) {
    const std::int64_t n = static_cast<std::int64_t>(rows.shape(1)), half = static_cast<std::int64_t>(rows.shape(0)) / 2;
    if (static_cast<std::int64_t>(out.shape(0)) != n || rows.shape(0) % 2 != 1)
        throw std::invalid_argument("seed_costs: an odd number of rows, one cost for each column");
    const float *middle = rows.data() + half * n;
    float *costs = out.data();
    nb::gil_scoped_release released;
    constexpr std::int64_t kBlock = 2048;
    const std::size_t room = static_cast<std::size_t>(kBlock + 2 * half);
    std::vector<float> run(room), next(room);
    const float step = static_cast<float>(bend), share = static_cast<float>(half + 1);
    for (std::int64_t first = 0; first < n; first += kBlock) {
        const std::int64_t last = std::min(n, first + kBlock);
        for (const std::int64_t direction : {1, -1}) {
            const std::int64_t towards = backwards ? -direction : direction;
            seed_side(middle, direction * n, n, half, towards, step, first, last, run, next);
            const std::int64_t low = towards > 0 ? first : std::max<std::int64_t>(0, first - 2 * half);
            for (std::int64_t j = first; j < last; ++j) {
                const float mean = (run[static_cast<std::size_t>(j - low)] + middle[j]) / share;
                costs[j] = direction > 0 ? mean : std::max(costs[j], mean);
            }
        }
    }
}

// The cheapest way through all rows that ends at each column, and the column it began at. Steps: one row and one column, one row
// and two columns, two rows and one column (which counts twice).
void subsequence(Rows rows, bool backwards, double bend, FloatCosts total_out, Path start_out) {
    const std::int64_t count = static_cast<std::int64_t>(rows.shape(0)), n = static_cast<std::int64_t>(rows.shape(1));
    if (count < 1 || static_cast<std::int64_t>(total_out.shape(0)) != n || static_cast<std::int64_t>(start_out.shape(0)) != n)
        throw std::invalid_argument("subsequence: one cost and one start for each column");
    float *const totals = total_out.data();
    std::int64_t *const starts = start_out.data();
    const float *const cells = rows.data();
    nb::gil_scoped_release released;
    constexpr float kFar = std::numeric_limits<float>::infinity();
    struct Row {
        std::vector<float> total;
        std::vector<std::int32_t> start;
    };
    const std::size_t size = static_cast<std::size_t>(n);
    Row before{std::vector<float>(size, kFar), std::vector<std::int32_t>(size)}, last = before, now = before;
    const float cost = static_cast<float>(bend);
    const auto row = [&](std::int64_t r) { return cells + (backwards ? count - 1 - r : r) * n; };
    for (std::size_t j = 0; j < size; ++j) {
        last.total[j] = row(0)[j];
        last.start[j] = before.start[j] = static_cast<std::int32_t>(j);
    }
    for (std::int64_t r = 1; r < count; ++r) {
        const float *here = row(r);
        now.total[0] = kFar;
        now.start[0] = last.start[0];
        for (std::size_t j = 1; j < size; ++j) {
            float best = last.total[j - 1] + here[j];
            std::int32_t from = last.start[j - 1];
            if (j >= 2) {
                const float two = last.total[j - 2] + here[j] + cost;
                from = two < best ? last.start[j - 2] : from;
                best = two < best ? two : best;
            }
            const float slow = before.total[j - 1] + 2.f * here[j] + cost;
            from = slow < best ? before.start[j - 1] : from;
            best = slow < best ? slow : best;
            now.total[j] = best;
            now.start[j] = from;
        }
        std::swap(before, last);
        std::swap(last, now);
    }
    for (std::size_t j = 0; j < size; ++j) {
        totals[j] = last.total[j];
        starts[j] = last.start[j];
    }
}

// The cheapest path from (first, last) inwards to the identity axis. Returns its cost and where it ends.
std::pair<double, std::int64_t> folded(Rows distance, Weights weight) {
    const std::int64_t n = static_cast<std::int64_t>(distance.shape(0));
    if (n < 1 || static_cast<std::int64_t>(distance.shape(1)) != n || static_cast<std::int64_t>(weight.shape(0)) != n)
        throw std::invalid_argument("folded: a square and one weight for each row");
    const float *cells = distance.data();
    const double *w = weight.data();
    nb::gil_scoped_release released;
    // row i holds the costs at (i from the front, j from the back), up to i + j = n - 1
    std::vector<double> cost(static_cast<std::size_t>(n), kInf);
    double best = kInf;
    std::int64_t end = 0;
    for (std::int64_t i = 0; i < n; ++i) {
        double left = kInf;
        for (std::int64_t j = 0; i + j < n; ++j) {
            const double cell = static_cast<double>(cells[i * n + (n - 1 - j)]);
            const double back = w[n - 1 - j];
            double here;
            if (i == 0 && j == 0) {
                here = cell * (w[0] + back);
            } else {
                const double down = i > 0 ? cost[static_cast<std::size_t>(j)] + cell * w[i] : kInf;
                here = std::min(down, left + cell * back);
            }
            cost[static_cast<std::size_t>(j)] = left = here;
        }
        const double last = cost[static_cast<std::size_t>(n - 1 - i)];
        if (last < best) best = last, end = i;
    }
    return {best, end};
}

// Mean distance along the best monotone way from corner to corner of each square block.
void warped(Blocks blocks, Costs out) {
    const std::int64_t count = static_cast<std::int64_t>(blocks.shape(0)), p = static_cast<std::int64_t>(blocks.shape(1));
    if (p < 1 || static_cast<std::int64_t>(blocks.shape(2)) != p || static_cast<std::int64_t>(out.shape(0)) != count)
        throw std::invalid_argument("warped: square blocks, one cost for each");
    std::vector<double> before(static_cast<std::size_t>(p) + 1), now(before);
    for (std::int64_t b = 0; b < count; ++b) {
        const float *cells = blocks.data() + b * p * p;
        std::fill(before.begin(), before.end(), kInf);
        before[0] = 0.0;
        for (std::int64_t i = 0; i < p; ++i) {
            now[0] = kInf;
            for (std::size_t j = 0; j < static_cast<std::size_t>(p); ++j) {
                const double here = static_cast<double>(cells[i * p + static_cast<std::int64_t>(j)]);
                now[j + 1] = here + std::min(before[j] + here, std::min(before[j + 1], now[j]));
            }
            std::swap(before, now);
        }
        out.data()[b] = before[static_cast<std::size_t>(p)] / static_cast<double>(2 * p);
    }
}

}  // namespace

void bind_paths(nb::module_ &m) {
    m.def("seed_costs", &seed_costs, "rows"_a.noconvert(), "bend"_a, "backwards"_a, "out"_a.noconvert());
    m.def("subsequence", &subsequence, "rows"_a.noconvert(), "backwards"_a, "bend"_a, "total"_a.noconvert(),
          "start"_a.noconvert());
    m.def("folded", &folded, "distance"_a.noconvert(), "weight"_a.noconvert());
    m.def("warped", &warped, "blocks"_a.noconvert(), "out"_a.noconvert());
    m.def("cheapest_path", &cheapest_path, "rows"_a.noconvert(), "low"_a, "width"_a, "bend"_a, "out"_a.noconvert());
    m.def("turning_costs", &turning_costs, "rows"_a.noconvert(), "reach"_a, "bend"_a, "out"_a.noconvert());
}
