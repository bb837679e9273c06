// slammot: filter or smoother?
#include "apps/app.h"

int main(int argc, char** argv) { return slammot::app::main(argc, argv); }
