// Numbers out of text, for the motion files: a whole file in one pass, exact to the last bit.
//
// Neither function raises on bad text: each stops at the first row (frame) that is not what was asked for and tells where
// it begins, so that the caller, which knows the format, can say what is wrong there.
#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <new>
#include <string>
#include <utility>
#include <vector>

namespace nb = nanobind;

namespace {

constexpr double POWERS_OF_TEN[] = {1e0,  1e1,  1e2,  1e3,  1e4,  1e5,  1e6,  1e7,  1e8,  1e9,  1e10, 1e11,
                                    1e12, 1e13, 1e14, 1e15, 1e16, 1e17, 1e18, 1e19, 1e20, 1e21, 1e22};

inline bool is_digit(char c) { return static_cast<unsigned char>(c - '0') < 10; }
inline bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\v' || c == '\f'; }
inline bool is_space(char c) { return is_blank(c) || c == '\n'; }

inline const char *skip_line(const char *p, const char *end) {
    const void *newline = std::memchr(p, '\n', static_cast<std::size_t>(end - p));
    return newline ? static_cast<const char *>(newline) + 1 : end;
}

// The rare number of many digits or a large exponent, rounded correctly.
bool parse_slowly(const char *first, const char *last, double &value) {
#if defined(__cpp_lib_to_chars) && __cpp_lib_to_chars >= 201611L
    if (*first == '+') ++first;
    const std::from_chars_result result = std::from_chars(first, last, value);
    if (result.ec == std::errc()) return result.ptr == last && std::isfinite(value);
    if (result.ec != std::errc::result_out_of_range) return false;
#endif
    // out of range is either too large, or so small that it is 0: strtod tells which
    const std::string token(first, last);
    char *stop = nullptr;
    value = std::strtod(token.c_str(), &stop);
    return stop == token.c_str() + token.size() && std::isfinite(value);
}

// Reads one decimal number that ends at white space or at `end`; returns where it ends, or nullptr.
inline const char *parse_number(const char *p, const char *end, double &value) {
    const char *first = p;
    bool negative = false;
    if (p < end && (*p == '-' || *p == '+')) negative = *p++ == '-';
    std::uint64_t mantissa = 0;
    const char *digits = p;
    while (p < end && is_digit(*p)) mantissa = mantissa * 10 + static_cast<std::uint64_t>(*p++ - '0');
    std::ptrdiff_t count = p - digits;
    int exponent = 0;
    if (p < end && *p == '.') {
        const char *fraction = ++p;
        while (p < end && is_digit(*p)) mantissa = mantissa * 10 + static_cast<std::uint64_t>(*p++ - '0');
        const std::ptrdiff_t places = p - fraction;
        count += places;
        exponent = places > 400 ? -400 : -static_cast<int>(places);
    }
    if (count == 0) return nullptr;
    if (p < end && (*p == 'e' || *p == 'E')) {
        ++p;
        bool down = false;
        if (p < end && (*p == '-' || *p == '+')) down = *p++ == '-';
        if (p == end || !is_digit(*p)) return nullptr;
        int power = 0;
        for (; p < end && is_digit(*p); ++p)
            if (power < 10000) power = power * 10 + (*p - '0');
        exponent += down ? -power : power;
    }
    if (p < end && !is_space(*p)) return nullptr;
    // Clinger 1990: mantissa and power of ten are both exact doubles, so one operation rounds once, correctly.
    // With up to 18 digits the mantissa has not overflowed.
    if (count <= 18 && mantissa <= (std::uint64_t{1} << 53) && exponent >= -22 && exponent <= 22) {
        const double whole = static_cast<double>(mantissa);
        const double size = exponent < 0 ? whole / POWERS_OF_TEN[-exponent] : whole * POWERS_OF_TEN[exponent];
        value = negative ? -size : size;
        return p;
    }
    return parse_slowly(first, p, value) ? p : nullptr;
}

using Table = nb::ndarray<nb::numpy, double, nb::ndim<2>>;

Table make_table(std::vector<double> &&values, std::size_t columns) {
    auto *owned = new std::vector<double>(std::move(values));
    nb::capsule owner(owned, [](void *p) noexcept { delete static_cast<std::vector<double> *>(p); });
    return Table(owned->data(), {owned->size() / columns, columns}, owner);
}

// Rows of `columns` numbers, one row a line; blank lines and lines that begin with # or // are passed over.
std::pair<Table, std::int64_t> parse_rows(nb::bytes data, std::size_t start, std::size_t columns) {
    const char *begin = data.c_str();
    const char *end = begin + data.size();
    std::vector<double> values;
    std::int64_t bad = -1;
    {
        nb::gil_scoped_release release;
        const char *p = begin + (start < data.size() ? start : data.size());
        while (p < end) {
            const char *row = p;
            while (p < end && is_space(*p)) {
                if (*p == '\n') row = p + 1;
                ++p;
            }
            if (p == end) break;
            if (*p == '#' || (*p == '/' && p + 1 < end && p[1] == '/')) {
                p = skip_line(p, end);
                continue;
            }
            const std::size_t before = values.size();
            if (before + columns > values.capacity()) {
                // the first line tells how long the others are; later growth is by doubling; a number takes two bytes
                const std::size_t left = static_cast<std::size_t>(end - row);
                const std::size_t line = static_cast<std::size_t>(skip_line(p, end) - row);
                const std::size_t guess = (left / line + 2) * columns;
                const std::size_t most = before + left / 2 + columns;
                values.reserve(std::min(before == 0 ? guess : 2 * values.capacity() + columns, most));
            }
            std::size_t count = 0;
            while (p < end && *p != '\n') {
                double value;
                const char *next = count < columns ? parse_number(p, end, value) : nullptr;
                if (next == nullptr) {
                    count = columns + 1;
                    break;
                }
                values.push_back(value);
                ++count;
                p = next;
                while (p < end && is_blank(*p)) ++p;
            }
            if (count != columns) {
                values.resize(before);
                bad = row - begin;
                break;
            }
        }
    }
    return {make_table(std::move(values), columns), bad};
}

// Frames of labelled numbers: a line with the frame number, then a line for each label: the word and so many numbers.
std::pair<Table, std::int64_t> parse_labelled(nb::bytes data, std::size_t start, const std::vector<std::string> &labels,
                                              const std::vector<std::size_t> &counts) {
    const char *begin = data.c_str();
    const char *end = begin + data.size();
    std::size_t columns = 1;
    for (const std::size_t count : counts) columns += count;
    std::vector<double> values;
    std::int64_t bad = -1;
    {
        nb::gil_scoped_release release;
        const char *p = begin + (start < data.size() ? start : data.size());
        const char *line = p;
        bool fresh_line = true;
        auto skip_blanks = [&] {
            while (p < end && is_blank(*p)) ++p;
        };
        auto to_next_line = [&] {
            while (p < end) {
                if (*p == '\n') {
                    fresh_line = true;
                    line = ++p;
                } else if (is_blank(*p)) {
                    ++p;
                } else if (fresh_line && *p == '#') {
                    line = p = skip_line(p, end);
                } else {
                    break;
                }
            }
            return fresh_line && p < end;
        };
        auto number = [&] {
            double value;
            const char *next = parse_number(p, end, value);
            if (next == nullptr) return false;
            fresh_line = false;
            values.push_back(value);
            p = next;
            return true;
        };
        auto line_ends = [&] {
            skip_blanks();
            return p == end || *p == '\n';
        };
        auto frame = [&] {
            if (!fresh_line || !number() || !line_ends()) return false;
            for (std::size_t i = 0; i < labels.size(); ++i) {
                if (!to_next_line()) return false;
                const std::string &label = labels[i];
                if (static_cast<std::size_t>(end - p) < label.size()) return false;
                if (std::memcmp(p, label.data(), label.size()) != 0) return false;
                p += label.size();
                fresh_line = false;
                if (p < end && !is_space(*p)) return false;
                for (std::size_t k = 0; k < counts[i]; ++k) {
                    skip_blanks();
                    if (!number()) return false;
                }
                if (!line_ends()) return false;
            }
            return true;
        };
        for (to_next_line(); p < end; to_next_line()) {
            const char *first = line;
            const std::size_t before = values.size();
            if (before + columns > values.capacity() && before > 0) {
                const std::size_t bytes_a_frame =
                    (static_cast<std::size_t>(first - begin) - start) * columns / before + 1;
                values.reserve(before + (static_cast<std::size_t>(end - first) / bytes_a_frame + 2) * columns);
            }
            if (!frame()) {
                values.resize(before);
                bad = first - begin;
                break;
            }
        }
    }
    return {make_table(std::move(values), columns), bad};
}

}  // namespace

void bind_text(nb::module_ &m) {
    m.def("parse_rows", &parse_rows, nb::arg("data"), nb::arg("start"), nb::arg("columns"),
          "Rows of numbers, one a line, from byte `start` on: an array (rows, columns), and the byte where the first line "
          "begins that does not hold `columns` finite numbers, or -1.");
    m.def("parse_labelled", &parse_labelled, nb::arg("data"), nb::arg("start"), nb::arg("labels"), nb::arg("counts"),
          "Frames of labelled numbers from byte `start` on: an array (frames, 1 + sum(counts)) whose first column is the "
          "frame number, and the byte where the first frame begins that is not of this layout, or -1.");
}
