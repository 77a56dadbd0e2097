#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "base/reduce.hpp"
#include "base/stop.hpp"
