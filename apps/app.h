// The program: all commands. Exit codes: 0 done, 1 the run failed, 2 bad usage or bad input.
#pragma once

namespace slammot::app {

int main(int argc, char** argv);

}  // namespace slammot::app
