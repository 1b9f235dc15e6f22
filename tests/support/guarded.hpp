#pragma once

#include <sys/mman.h>
#include <unistd.h>

#include <cstddef>
#include <new>

/// A page of memory before one that nobody may read or write.
class GuardedPage {
public:
    GuardedPage() : size_{static_cast<std::size_t>(::sysconf(_SC_PAGESIZE))} {
        begin_ = ::mmap(nullptr, 2 * size_, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
        if (begin_ == MAP_FAILED) throw std::bad_alloc();
        if (::mprotect(end(), size_, PROT_NONE) != 0) throw std::bad_alloc();
    }
    ~GuardedPage() { ::munmap(begin_, 2 * size_); }
    GuardedPage(const GuardedPage&) = delete;
    GuardedPage& operator=(const GuardedPage&) = delete;

    /// First forbidden byte.
    void* end() const { return static_cast<std::byte*>(begin_) + size_; }

private:
    std::size_t size_;
    void* begin_;
};
