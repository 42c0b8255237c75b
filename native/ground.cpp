// The pass over known ground: where each moment was before. The NumPy twin is in kinesics/grammar/ground.py.
#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/tuple.h>

#include <algorithm>
#include <cstdint>
#include <limits>
#include <stdexcept>
#include <tuple>
#include <vector>

namespace nb = nanobind;
using namespace nb::literals;

namespace {

using Tile = nb::ndarray<const float, nb::shape<-1, -1>, nb::device::cpu>;
using Places = nb::ndarray<std::int64_t, nb::shape<-1>, nb::c_contig, nb::device::cpu>;
using Floats = nb::ndarray<float, nb::shape<-1>, nb::c_contig, nb::device::cpu>;
using Flags = nb::ndarray<bool, nb::shape<-1>, nb::c_contig, nb::device::cpu>;

constexpr float kInf = std::numeric_limits<float>::infinity();
// One moment further, the place on the ground is this near to the one before.
constexpr std::int64_t kFollowed = 6;

// A local minimum deepened to what it is between the samples.
float valley(const float *row, std::int64_t k, std::int64_t count) {
    const float b = row[k];
    if (k == 0 || k + 1 >= count) return b;
    const float a = row[k - 1], c = row[k + 1];
    if (!(b <= a && b <= c)) return b;
    const float bend = a - 2.f * b + c;
    if (!(bend > 1e-9f)) return b;
    const float apart = a - c;
    return std::max(b - apart * apart / (8.f * bend), 0.f);
}

struct Least {
    std::int64_t at = 0;
    float value = kInf;
};

Least least(const float *row, const float *farthest, float limit, std::int64_t first, std::int64_t last, std::int64_t count) {
    Least out{first, kInf};
    for (std::int64_t k = first; k < last; ++k) {
        if (!(farthest[k] > limit)) continue;
        const float value = valley(row, k, count);
        if (value < out.value) out = {k, value};
    }
    return out;
}

// Moments [first, first + rows) of a recording. Columns of d and s: the ground so far, `count` places, then these moments.
// Returns how many places there are now, and the place of the last moment (-1: none) and whether it is mirrored there.
std::tuple<std::int64_t, std::int64_t, bool> localise(Tile d, Tile s, std::int64_t first, double same, std::int64_t count,
                                                      std::int64_t last, bool last_mirrored, Places ground, Floats farthest,
                                                      Flags is_new, Places where, Flags mirrored) {
    const std::int64_t rows = static_cast<std::int64_t>(d.shape(0)), before = count;
    const std::int64_t n = static_cast<std::int64_t>(ground.shape(0));
    if (static_cast<std::int64_t>(d.shape(1)) != count + rows || s.shape(0) != d.shape(0) || s.shape(1) != d.shape(1) ||
        d.stride(1) != 1 || s.stride(1) != 1 || count < 0 || first < count || first + rows > n ||
        static_cast<std::int64_t>(farthest.shape(0)) != n || static_cast<std::int64_t>(is_new.shape(0)) != n ||
        static_cast<std::int64_t>(where.shape(0)) != n || static_cast<std::int64_t>(mirrored.shape(0)) != n || last >= count)
        throw std::invalid_argument("localise: shapes do not fit");
    const float near = static_cast<float>(same), limit = static_cast<float>(4.0 * same), even = static_cast<float>(0.2 * same);
    float *const far = farthest.data();
    nb::gil_scoped_release released;
    std::vector<float> here(static_cast<std::size_t>(count + rows)), image(here);
    for (std::int64_t r = 0; r < rows; ++r) {
        const std::int64_t t = first + r;
        const float *d_row = d.data() + r * d.stride(0), *s_row = s.data() + r * s.stride(0);
        std::copy_n(d_row, before, here.data());
        std::copy_n(s_row, before, image.data());
        for (std::int64_t k = before; k < count; ++k) {
            here[static_cast<std::size_t>(k)] = d_row[before + ground.data()[k] - first];
            image[static_cast<std::size_t>(k)] = s_row[before + ground.data()[k] - first];
        }
        for (std::int64_t k = 0; k < count; ++k) far[k] = std::max(far[k], here[static_cast<std::size_t>(k)]);
        std::int64_t found = -1;
        bool found_mirrored = false;
        if (last >= 0) {
            const float *row = last_mirrored ? image.data() : here.data();
            const Least close = least(row, far, limit, std::max<std::int64_t>(0, last - kFollowed),
                                      std::min(count, last + kFollowed + 1), count);
            if (close.value < near) found = close.at, found_mirrored = last_mirrored;
        }
        if (found < 0) {
            const Least straight = least(here.data(), far, limit, 0, count, count);
            const Least turned = least(image.data(), far, limit, 0, count, count);
            if (std::min(straight.value, turned.value) < near) {
                // where both fit, near a symmetric pose, the unmirrored one
                found_mirrored = !(straight.value <= turned.value + even);
                found = found_mirrored ? turned.at : straight.at;
            }
        }
        is_new.data()[t] = found < 0;
        if (found < 0) {
            ground.data()[count] = t;
            far[count] = 0.f;
            ++count;
        } else {
            where.data()[t] = ground.data()[found];
            mirrored.data()[t] = found_mirrored;
        }
        last = found;
        last_mirrored = found_mirrored;
    }
    return {count, last, last_mirrored};
}

}  // namespace

void bind_ground(nb::module_ &m) {
    m.def("localise", &localise, "d"_a.noconvert(), "s"_a.noconvert(), "first"_a, "same"_a, "count"_a, "last"_a,
          "last_mirrored"_a, "ground"_a.noconvert(), "farthest"_a.noconvert(), "new"_a.noconvert(), "where"_a.noconvert(),
          "mirrored"_a.noconvert());
}
