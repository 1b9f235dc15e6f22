#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>

#include "perimpm/error.hpp"
#include "perimpm/io/frame_writer.hpp"

namespace perimpm {

void write_text_file(const std::string& path, const std::string& text) {
    const std::string aside = path + ".part";
    std::ofstream file(aside, std::ios::binary);
    file << text;
    file.close();
    if (!file || std::rename(aside.c_str(), path.c_str()) != 0) {
        const std::string reason = std::strerror(errno);
        std::error_code ignored;
        std::filesystem::remove(aside, ignored);
        throw InputError(path,
                         "cannot write the file: " + reason + "; choose a folder that can be written and has room");
    }
}

}  // namespace perimpm
