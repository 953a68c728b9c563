// The verbs of the program. To add one: write command_<verb>.cpp, declare its function here, list it in main.cpp.
#pragma once

#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <functional>

namespace tsc::cli {

/// What runs when the verb was given; returns the exit code.
using CommandBody = std::function<int()>;

/// Each adds its subcommand with the options to `app`. The body stays valid as long as `app`.
CommandBody addPackCommand(CLI::App& app);
CommandBody addUnpackCommand(CLI::App& app);
CommandBody addInspectCommand(CLI::App& app);
CommandBody addCompareCommand(CLI::App& app);

}  // namespace tsc::cli
