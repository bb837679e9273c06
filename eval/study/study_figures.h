// What a study's report can draw and tabulate, and what each needs.
#pragma once

#include <string>

#include "eval/study/study.h"

namespace slammot {

// A name of the table of figures, or `against_sweep:KEY` of a number. Throws std::invalid_argument.
void require_figure(const std::string& figure);

// A number of a cell: a metric that is pooled, or anees_pose, anees_position, anees_rotation.
// Throws std::invalid_argument.
void require_number(const std::string& key);

// What the figures draw must be there. Throws std::invalid_argument.
void check_figures(const Study& study);

// Whether the errors of each axis are recorded, in the first run of each cell.
bool records_axes(const Study& study);

}  // namespace slammot
