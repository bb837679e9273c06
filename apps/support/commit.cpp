// Alone in its unit, because the header changes with every commit.
#include "apps/support/commit.h"

#include <slammot_commit.h>

#include "eval/provenance/provenance.h"

namespace slammot {

void state_own_commit() { state_commit(kCommit, kModified); }

}  // namespace slammot
