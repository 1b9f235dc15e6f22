#pragma once

#include <cstdlib>
#include <filesystem>
#include <optional>
#include <string>

/// Sets an environment variable while it lives, or unsets it.
class EnvironmentVariable {
public:
    EnvironmentVariable(const char* name, const std::optional<std::string>& value) : name_{name} {
        if (const char* before = std::getenv(name)) before_ = before;
        put(value);
    }
    ~EnvironmentVariable() { put(before_); }
    EnvironmentVariable(const EnvironmentVariable&) = delete;
    EnvironmentVariable& operator=(const EnvironmentVariable&) = delete;

private:
    void put(const std::optional<std::string>& value) {
        value ? ::setenv(name_, value->c_str(), 1) : ::unsetenv(name_);
    }

    const char* name_;
    std::optional<std::string> before_;
};

/// A new folder that is removed with everything in it.
class TemporaryFolder {
public:
    TemporaryFolder() {
        std::string pattern = std::filesystem::temp_directory_path() / "perimpm_test_XXXXXX";
        path = std::filesystem::canonical(::mkdtemp(pattern.data()));
    }
    ~TemporaryFolder() { std::filesystem::remove_all(path); }
    TemporaryFolder(const TemporaryFolder&) = delete;
    TemporaryFolder& operator=(const TemporaryFolder&) = delete;

    std::filesystem::path path;
};
