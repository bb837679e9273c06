// The commit this program was built from, for provenance.h.
#pragma once

namespace slammot {

void state_own_commit();

}  // namespace slammot
