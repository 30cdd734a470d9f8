// Memory for packs: given out piece by piece, aligned to 64 bytes, and freed all at once.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdlib>
#include <memory>
#include <new>
#include <vector>

namespace serpenoid {

class PackMemory {
  public:
    // Doubles of no value.
    double* take(std::size_t count) {
        count = (count + 7) / 8 * 8;
        if (count > left_) {
            left_ = std::max(count, kBlock);
            blocks_.emplace_back(static_cast<double*>(std::aligned_alloc(64, left_ * 8)));
            next_ = blocks_.back().get();
            if (!next_) throw std::bad_alloc();
        }
        next_ += count, left_ -= count;
        return next_ - count;
    }

  private:
    static constexpr std::size_t kBlock = 7936;  // what six links need, below malloc's large sizes
    struct Free {
        void operator()(double* p) const { std::free(p); }
    };
    std::vector<std::unique_ptr<double[], Free>> blocks_;
    double* next_ = nullptr;
    std::size_t left_ = 0;
};

}  // namespace serpenoid
