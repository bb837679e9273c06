// What of the method is in force in a run: each mechanism that the thesis does not have, whether it
// acts, and if not, which option keeps it from acting.
//
// A mechanism states itself where it is decided whether it acts, in the loop or in a family's
// belief, never from the configuration's text: an option that is on in `run.yaml` may be without
// effect beside another one.
#pragma once

#include <string>
#include <vector>

namespace slammot {

struct Mechanism {
  std::string name;    // in words, the same in every file and page
  std::string key;     // the configuration key that turns it off
  bool is_on = false;  // whether it can act, with all options as they are
  std::string
      because;     // off although its key is on: the option or the statement that it is without
  long acted = 0;  // times that it changed something; 0: it never had to
};

using InForce = std::vector<Mechanism>;

}  // namespace slammot
