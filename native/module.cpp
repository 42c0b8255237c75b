// kinesics._native: the compiled kernels. One bind_ function for each source file.
#include <nanobind/nanobind.h>

namespace nb = nanobind;

void bind_similarity(nb::module_ &m);
void bind_kinematics(nb::module_ &m);
void bind_paths(nb::module_ &m);
void bind_ground(nb::module_ &m);
void bind_togo(nb::module_ &m);
void bind_body(nb::module_ &m);
void bind_smoothing(nb::module_ &m);
void bind_legs(nb::module_ &m);
void bind_quaternions(nb::module_ &m);
void bind_footing(nb::module_ &m);
void bind_live(nb::module_ &m);
void bind_cuts(nb::module_ &m);
void bind_weighing(nb::module_ &m);
void bind_ranges(nb::module_ &m);
void bind_pivots(nb::module_ &m);
void bind_taut(nb::module_ &m);
#ifdef KINESICS_TEXT
void bind_text(nb::module_ &m);
#endif

NB_MODULE(_native, m) {
    m.doc() = "Compiled kernels of kinesics; nothing here checks values, its callers do.";
    // a script that ends while a performance goes on has leaked nothing
    nb::set_leak_warnings(false);
    bind_similarity(m);
    bind_kinematics(m);
    bind_paths(m);
    bind_ground(m);
    bind_togo(m);
    bind_body(m);
    bind_smoothing(m);
    bind_legs(m);
    bind_quaternions(m);
    bind_footing(m);
    bind_ranges(m);
    bind_pivots(m);
    bind_taut(m);
    bind_live(m);
    bind_cuts(m);
    bind_weighing(m);
#ifdef KINESICS_TEXT
    bind_text(m);
#endif
}
