// SPDX-License-Identifier: MIT
#include "tools/loopsift_tool/commands.hpp"

int main(int argc, char** argv) { return loopsift::tool::run_tool(argc, argv); }
