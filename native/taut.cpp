// A string pulled taut in a tube. The Python twin is in kinesics/synthesis/embodiment/steady_feet.py.
#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>

#include <algorithm>
#include <cstddef>
#include <limits>
#include <optional>
#include <stdexcept>
#include <vector>

namespace nb = nanobind;
using namespace nb::literals;

namespace {

using Values = nb::ndarray<const double, nb::shape<-1>, nb::c_contig, nb::device::cpu>;
using Out = nb::ndarray<double, nb::shape<-1>, nb::c_contig, nb::device::cpu>;

struct Point {
    double x, y;
};

double slope(const Point &a, const Point &b) { return (b.y - a.y) / (b.x - a.x); }

// What the string may have to go round on one side, from its last corner on: taken from both ends, added to at the back.
struct Hull {
    std::vector<Point> points;
    std::size_t first = 0;

    std::size_t size() const { return points.size() - first; }
    Point &front() { return points[first]; }
    const Point &second() const { return points[first + 1]; }
};

// Where a string begins that is free to: level with what it goes round first; none where nothing is in its way.
template <class Low, class High>
std::optional<double> level(std::size_t count, Low low, High high) {
    double least = -std::numeric_limits<double>::infinity(), most = std::numeric_limits<double>::infinity();
    for (std::size_t t = 0; t < count; ++t) {
        if (low(t) > most) return most;
        if (high(t) < least) return least;
        least = std::max(least, low(t));
        most = std::min(most, high(t));
    }
    return std::nullopt;
}

// One more point on one side (1 below, −1 above).
void extended(Hull &hull, Hull &other, const Point &point, double side, std::vector<Point> &corners) {
    while (hull.size() > 1) {
        const Point &last = hull.points.back(), &before = hull.points[hull.points.size() - 2];
        if (side * (slope(before, last) - slope(last, point)) > 0.0) break;
        hull.points.pop_back();
    }
    // past the other side: the string is bent round what lies there first
    while (hull.size() == 1 && other.size() > 1 &&
           side * (slope(other.front(), point) - slope(other.front(), other.second())) > 0.0) {
        ++other.first;
        corners.push_back(other.front());
        hull.front() = other.front();
    }
    hull.points.push_back(point);
}

std::size_t taut(Values low, Values high, Values at, Out where, Out height) {
    const std::size_t count = at.shape(0);
    if (low.shape(0) != count || high.shape(0) != count || where.shape(0) < 2 * count || height.shape(0) < 2 * count)
        throw std::invalid_argument("taut: shapes do not fit");
    nb::gil_scoped_release released;
    const double *floor = low.data(), *ceiling = high.data(), *place = at.data();
    const auto begin = level(count, [=](std::size_t t) { return floor[t]; }, [=](std::size_t t) { return ceiling[t]; });
    const auto end = level(
        count, [=](std::size_t t) { return floor[count - 1 - t]; }, [=](std::size_t t) { return ceiling[count - 1 - t]; });
    if (!begin || !end) return 0;
    std::vector<Point> corners{{place[0], *begin}};
    Hull below{corners}, above{corners};
    for (std::size_t t = 1; t < count; ++t) {
        const bool last = t + 1 == count;
        extended(below, above, {place[t], last ? *end : floor[t]}, 1.0, corners);
        extended(above, below, {place[t], last ? *end : ceiling[t]}, -1.0, corners);
    }
    corners.push_back({place[count - 1], *end});
    // each place is a corner twice at most, where the tube is closed
    for (std::size_t n = 0; n < corners.size(); ++n) {
        where.data()[n] = corners[n].x;
        height.data()[n] = corners[n].y;
    }
    return corners.size();
}

}  // namespace

void bind_taut(nb::module_ &m) {
    m.def("taut", &taut, "low"_a.noconvert(), "high"_a.noconvert(), "at"_a.noconvert(), "where"_a.noconvert(),
          "height"_a.noconvert());
}
