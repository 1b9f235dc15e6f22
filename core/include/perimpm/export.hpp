#pragma once

/// Marks what the core library exports; everything else is hidden.
#define PERIMPM_API __attribute__((visibility("default")))
