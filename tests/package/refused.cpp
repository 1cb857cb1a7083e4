#include "controller/lcs/lcs.hpp"
