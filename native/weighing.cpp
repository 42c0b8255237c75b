// What many composites are weighed as at once: by where they lead, and by what was played before. The NumPy twins are in
// kinesics/synthesis/goals/places.py and favours.py.
#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <stdexcept>

namespace nb = nanobind;
using namespace nb::literals;

namespace {

using Table = nb::ndarray<const float, nb::shape<-1, -1>, nb::c_contig, nb::device::cpu>;
using Paths = nb::ndarray<const std::int32_t, nb::shape<-1, -1>, nb::c_contig, nb::device::cpu>;
using Numbers = nb::ndarray<const double, nb::shape<-1>, nb::c_contig, nb::device::cpu>;
// z and x of a place stand one behind the other: twice as many columns as points. Rows and single points are cut from larger ones.
using Cut = nb::ndarray<const float, nb::shape<-1, -1>, nb::device::cpu>;
using Wishes = nb::ndarray<const double, nb::shape<-1, 3>, nb::c_contig, nb::device::cpu>;
using Out = nb::ndarray<double, nb::shape<-1>, nb::c_contig, nb::device::cpu>;
using OutTable = nb::ndarray<double, nb::shape<-1, -1>, nb::c_contig, nb::device::cpu>;

void require(bool good, const char *what) {
    if (!good) throw std::invalid_argument(what);
}

// out(r): the values of the paths of composite r (below 0: none), each times its share, together.
void shared_values(Numbers values, Paths sequence, Table shares, Out out) {
    const auto rows = std::int64_t(sequence.shape(0)), columns = std::int64_t(sequence.shape(1));
    const auto count = std::int64_t(values.shape(0));
    require(std::int64_t(shares.shape(0)) == rows && std::int64_t(shares.shape(1)) == columns &&
                std::int64_t(out.shape(0)) == rows,
            "kinesics._native.shared_values: shapes do not fit");
    for (std::int64_t r = 0; r < rows; ++r) {
        double total = 0.0;
        for (std::int64_t c = 0; c < columns; ++c) {
            const std::int64_t path = sequence(r, c);
            require(path < count, "kinesics._native.shared_values: no such path");
            if (path >= 0) total += double(shares(r, c)) * values(path);
        }
        out(r) = total;
    }
}

// out(r) += by how much too soon composite r plays what was last played at `last_played`, or within itself, each times its share.
void too_soon(Numbers last_played, double now, Paths paths, Table begins, Table again, Table shares, double within, Out out) {
    const auto rows = std::int64_t(paths.shape(0)), columns = std::int64_t(paths.shape(1));
    const auto count = std::int64_t(last_played.shape(0));
    bool good = std::int64_t(out.shape(0)) == rows && count > 0;
    for (const auto *table : {&begins, &again, &shares})
        good = good && std::int64_t(table->shape(0)) == rows && std::int64_t(table->shape(1)) == columns;
    require(good, "kinesics._native.too_soon: shapes do not fit");
    for (std::int64_t r = 0; r < rows; ++r) {
        double total = 0.0;
        for (std::int64_t c = 0; c < columns; ++c) {
            const std::int64_t path = paths(r, c);
            require(path < count, "kinesics._native.too_soon: no such path");
            // of a path that is not there nothing counts
            if (path < 0) continue;
            const float age = float(now - last_played(path)), since = std::min(begins(r, c) + age, again(r, c));
            total += double(shares(r, c)) * std::max(1.0 - double(since) / within, 0.0);
        }
        out(r) += total;
    }
}

struct Points {
    std::int64_t rows, points;
    Cut places, swerve;

    Points(Cut places, Cut swerve)
        : rows(std::int64_t(places.shape(0))), points(std::int64_t(places.shape(1)) / 2), places(places), swerve(swerve) {}

    bool fit(const OutTable &out) const {
        return std::int64_t(places.shape(1)) == 2 * points && std::int64_t(swerve.shape(0)) == rows &&
               std::int64_t(swerve.shape(1)) == 2 * points && std::int64_t(out.shape(0)) == rows &&
               std::int64_t(out.shape(1)) == points;
    }

    // Squared metres from a place, bent as much towards it as may be.
    float square(std::int64_t r, std::int64_t p, float z, float x, float most) const {
        float off_z = places(r, 2 * p) - z, off_x = places(r, 2 * p + 1) - x;
        if (most > 0.f) {
            const float sz = swerve(r, 2 * p), sx = swerve(r, 2 * p + 1);
            const float bend = -(off_z * sz + off_x * sx) / (sz * sz + sx * sx + 1e-9f);
            const float held = std::min(std::max(bend, -most), most);
            off_z += held * sz;
            off_x += held * sx;
        }
        return off_z * off_z + off_x * off_x;
    }
};

// out(r, p): what it costs to be within a distance of the target at a point of a trail, infinite where one is not.
void met_at(Cut places, Cut swerve, Cut times, float z, float x, float most, float within, double pace, double straight,
            double late, OutTable out) {
    const Points all(places, swerve);
    const auto clocks = std::int64_t(times.shape(0));
    require(all.fit(out) && std::int64_t(times.shape(1)) == all.points && (clocks == 1 || clocks == all.rows),
            "kinesics._native.met_at: shapes do not fit");
    for (std::int64_t r = 0; r < all.rows; ++r)
        for (std::int64_t p = 0; p < all.points; ++p) {
            const float square = all.square(r, p, z, x, most);
            const double waited = late * std::max(pace * double(times(clocks == 1 ? 0 : r, p)) - straight, 0.0);
            out(r, p) = square <= within ? double(square) + waited * waited : std::numeric_limits<double>::infinity();
        }
}

// out(r, p): squared metres from what is wished for at a point of a trail, what is late and what is faced away from counting too.
// wish: where it lies (z, x) as far as can be reached, and how far it truly is, one or one for each point.
void sought(Cut places, Cut swerve, Cut headings, Cut times, Wishes wish, float most, double reach, double pace, double haste,
            double facing, OutTable out) {
    const Points all(places, swerve);
    const auto clocks = std::int64_t(times.shape(0)), wishes = std::int64_t(wish.shape(0));
    require(all.fit(out) && std::int64_t(times.shape(1)) == all.points && (clocks == 1 || clocks == all.rows) &&
                std::int64_t(headings.shape(0)) == all.rows && std::int64_t(headings.shape(1)) == all.points &&
                (wishes == 1 || wishes == all.points),
            "kinesics._native.sought: shapes do not fit");
    for (std::int64_t r = 0; r < all.rows; ++r)
        for (std::int64_t p = 0; p < all.points; ++p) {
            const std::int64_t w = wishes == 1 ? 0 : p;
            const double z = wish(w, 0), x = wish(w, 1), far = wish(w, 2);
            double miss = double(all.square(r, p, float(z), float(x), most));
            if (pace > 0.0) {
                const double due = std::min(far, reach) / pace, late = haste * (double(times(clocks == 1 ? 0 : r, p)) - due);
                // what is behind one has to be turned to first: as far as one walks meanwhile
                const double beyond = std::max(1.0, far / reach);
                const double ahead_z = z * beyond - double(places(r, 2 * p)), ahead_x = x * beyond - double(places(r, 2 * p + 1));
                const double off = std::remainder(std::atan2(ahead_x, ahead_z) - double(headings(r, p)), 2.0 * 3.14159265358979323846);
                const double turned = facing * off * std::min(1.0, std::sqrt(ahead_z * ahead_z + ahead_x * ahead_x) / reach);
                miss += late * late + turned * turned;
            }
            out(r, p) = miss;
        }
}

}  // namespace

void bind_weighing(nb::module_ &m) {
    m.def("shared_values", &shared_values, "values"_a.noconvert(), "sequence"_a.noconvert(), "shares"_a.noconvert(),
          "out"_a.noconvert());
    m.def("too_soon", &too_soon, "last_played"_a.noconvert(), "now"_a, "paths"_a.noconvert(), "begins"_a.noconvert(),
          "again"_a.noconvert(), "shares"_a.noconvert(), "within"_a, "out"_a.noconvert());
    m.def("met_at", &met_at, "places"_a.noconvert(), "swerve"_a.noconvert(), "times"_a.noconvert(), "z"_a, "x"_a, "most"_a,
          "within"_a, "pace"_a, "straight"_a, "late"_a, "out"_a.noconvert());
    m.def("sought", &sought, "places"_a.noconvert(), "swerve"_a.noconvert(), "headings"_a.noconvert(), "times"_a.noconvert(),
          "wish"_a.noconvert(), "most"_a, "reach"_a, "pace"_a, "haste"_a, "facing"_a, "out"_a.noconvert());
}
