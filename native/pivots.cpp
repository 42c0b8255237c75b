// The point of a sole that a foot stands on, and how far it goes. The NumPy twins are in
// kinesics/synthesis/embodiment/pivots.py.
#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <stdexcept>
#include <vector>

namespace nb = nanobind;
using namespace nb::literals;

namespace {

using Steps = nb::ndarray<const double, nb::shape<-1, 3, 3>, nb::c_contig, nb::device::cpu>;
using Rows = nb::ndarray<const double, nb::shape<-1, 3>, nb::c_contig, nb::device::cpu>;
using Values = nb::ndarray<const double, nb::shape<-1>, nb::c_contig, nb::device::cpu>;
using Way = nb::ndarray<const double, nb::shape<-1, 2>, nb::c_contig, nb::device::cpu>;
using Bounds = nb::ndarray<const std::int64_t, nb::shape<-1>, nb::c_contig, nb::device::cpu>;
using Spread = nb::ndarray<double, nb::shape<-1>, nb::c_contig, nb::device::cpu>;
using Chosen = nb::ndarray<std::int32_t, nb::shape<-1>, nb::c_contig, nb::device::cpu>;

// Points along a sole: their parts of heel, ball and tip, one after the other so that the loop over them is vectorised.
struct Along {
    std::vector<double> heel, ball, tip;
};

// What each point costs in one step: its way over the floor, that of the farthest where it is too high to bear, and what a turn
// beside heel and ball does.
void costs(const double *step, const double *height, double farthest, double turn, const Along &parts, const double *beside,
           std::size_t count, double gives, double rise, double *out) {
    const double lowest = std::min({height[0], height[1], height[2]}) + gives, high = farthest / rise;
    const double x0 = step[0], x1 = step[3], x2 = step[6], z0 = step[2], z1 = step[5], z2 = step[8];
    const double h0 = height[0], h1 = height[1], h2 = height[2];
    const double *heel = parts.heel.data(), *ball = parts.ball.data(), *tip = parts.tip.data();
    for (std::size_t k = 0; k < count; ++k) {
        const double x = heel[k] * x0 + ball[k] * x1 + tip[k] * x2, z = heel[k] * z0 + ball[k] * z1 + tip[k] * z2;
        const double above = heel[k] * h0 + ball[k] * h1 + tip[k] * h2 - lowest;
        out[k] = std::sqrt(x * x + z * z) + high * (above > 0.0 ? above : 0.0) + turn * beside[k];
    }
}

// From where each point is come to at least cost, which takes the place of the total: a change costs `slope` for each point
// farther along, at most `most`. One that does just as well stays.
void changed(double slope, double most, std::size_t count, double *total, std::int32_t *came) {
    const std::size_t first = static_cast<std::size_t>(std::min_element(total, total + count) - total);
    const double least = total[first] + most;
    if (slope == 0.0) {
        // where nothing turns all is free
        for (std::size_t k = 0; k < count; ++k) came[k] = static_cast<std::int32_t>(least < total[k] ? first : k);
        std::fill_n(total, count, least);
        return;
    }
    for (std::size_t k = 0; k < count; ++k) came[k] = static_cast<std::int32_t>(k);
    for (std::size_t k = 1; k < count; ++k)
        if (total[k - 1] + slope < total[k]) total[k] = total[k - 1] + slope, came[k] = came[k - 1];
    for (std::size_t k = count - 1; k-- > 0;)
        if (total[k + 1] + slope < total[k]) total[k] = total[k + 1] + slope, came[k] = came[k + 1];
    for (std::size_t k = 0; k < count; ++k)
        if (least < total[k]) total[k] = least, came[k] = static_cast<std::int32_t>(first);
}

void stand_on(Steps step, Rows height, Values farthest, Values change, Values turn, Rows parts, Values beside, double apart,
              double far, double gives, double rise, Chosen out) {
    const std::size_t steps = step.shape(0), count = parts.shape(0);
    if (height.shape(0) != steps || farthest.shape(0) != steps || change.shape(0) != steps || turn.shape(0) != steps ||
        beside.shape(0) != count || out.shape(0) != steps || steps == 0 || count == 0)
        throw std::invalid_argument("stand_on: shapes do not fit");
    nb::gil_scoped_release released;
    std::vector<double> total(count), cost(count);
    std::vector<std::int32_t> came(steps * count);
    Along along{std::vector<double>(count), std::vector<double>(count), std::vector<double>(count)};
    for (std::size_t k = 0; k < count; ++k) {
        along.heel[k] = parts.data()[3 * k];
        along.ball[k] = parts.data()[3 * k + 1];
        along.tip[k] = parts.data()[3 * k + 2];
    }
    for (std::size_t t = 0; t < steps; ++t) {
        if (t > 0) changed(change.data()[t] * apart, change.data()[t] * far, count, total.data(), came.data() + t * count);
        costs(step.data() + 9 * t, height.data() + 3 * t, farthest.data()[t], turn.data()[t], along, beside.data(), count,
              gives, rise, cost.data());
        for (std::size_t k = 0; k < count; ++k) total[k] += cost[k];
    }
    auto at = static_cast<std::int32_t>(std::min_element(total.begin(), total.end()) - total.begin());
    for (std::size_t t = steps; t-- > 0;) {
        out.data()[t] = at;
        at = came[t * count + static_cast<std::size_t>(at)];
    }
}

// How far apart the places of a run are at most along eight directions, the first of them that in which they are spread most.
double spread(const double *way, std::size_t count) {
    double x = 0.0, z = 0.0;
    for (std::size_t t = 0; t < count; ++t) x += way[2 * t], z += way[2 * t + 1];
    x /= static_cast<double>(count), z /= static_cast<double>(count);
    double xx = 0.0, xz = 0.0, zz = 0.0;
    for (std::size_t t = 0; t < count; ++t) {
        const double a = way[2 * t] - x, b = way[2 * t + 1] - z;
        xx += a * a, xz += a * b, zz += b * b;
    }
    const double along = 0.5 * std::atan2(2.0 * xz, xx - zz);
    constexpr int directions = 8;
    double c[directions], s[directions], low[directions], high[directions];
    for (int n = 0; n < directions; ++n) {
        c[n] = std::cos(along + n * 3.14159265358979323846 / directions);
        s[n] = std::sin(along + n * 3.14159265358979323846 / directions);
        low[n] = std::numeric_limits<double>::infinity();
        high[n] = -low[n];
    }
    for (std::size_t t = 0; t < count; ++t) {
        const double a = way[2 * t] - x, b = way[2 * t + 1] - z;
        for (int n = 0; n < directions; ++n) {
            const double at = a * c[n] + b * s[n];
            low[n] = at < low[n] ? at : low[n];
            high[n] = at > high[n] ? at : high[n];
        }
    }
    double most = 0.0;
    for (int n = 0; n < directions; ++n) most = std::max(most, high[n] - low[n]);
    return most;
}

void spreads(Way way, Bounds starts, Bounds stops, Spread out) {
    const std::size_t count = out.shape(0);
    if (starts.shape(0) != count || stops.shape(0) != count) throw std::invalid_argument("spreads: shapes do not fit");
    for (std::size_t n = 0; n < count; ++n) {
        const std::int64_t a = starts.data()[n], b = stops.data()[n];
        if (a < 0 || b <= a || b > static_cast<std::int64_t>(way.shape(0)))
            throw std::invalid_argument("spreads: no such frames");
        out.data()[n] = spread(way.data() + 2 * a, static_cast<std::size_t>(b - a));
    }
}

}  // namespace

void bind_pivots(nb::module_ &m) {
    m.def("stand_on", &stand_on, "step"_a.noconvert(), "height"_a.noconvert(), "farthest"_a.noconvert(), "change"_a.noconvert(),
          "turn"_a.noconvert(), "parts"_a.noconvert(), "beside"_a.noconvert(), "apart"_a, "far"_a, "gives"_a, "rise"_a, "out"_a.noconvert());
    m.def("spreads", &spreads, "way"_a.noconvert(), "starts"_a.noconvert(), "stops"_a.noconvert(), "out"_a.noconvert());
}
