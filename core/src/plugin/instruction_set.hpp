#pragma once

#include <string>
#include <vector>

namespace perimpm {

/// Folders of plugin variants that this machine may run, best first; the baseline is "" and comes last.
/// Names follow the x86-64 psABI levels. PERIMPM_ISA = x86-64-v2 | x86-64-v3 | x86-64-v4 caps the
/// list. Throws InputError when PERIMPM_ISA is unknown or above what the machine supports, or the machine is below
/// x86-64-v2.
std::vector<std::string> instruction_set_folders();

/// What the plugins outside those folders are built for.
std::string baseline_name();

}  // namespace perimpm
