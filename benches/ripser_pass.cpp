// Ripser's C++ code, as PyPI's `ripser` ships it, as a process of its own over Z/2, compiled for this processor.
//
// In: a file with the lower triangle of a matrix of distances, as little-endian floats of four bytes. The folder of
// that package's ripser.cpp is on the include path.
// Out: the dots of H1 as one JSON list of [birth, death] in Ripser's scales, which are diameters; 1e999 is infinite.

#include "ripser.cpp"

#include <cstdio>

int main(int count, char **arguments) {
    std::ifstream file(count == 2 ? arguments[1] : "", std::ios::binary);
    std::vector<float> lower;
    for (float distance; file.read(reinterpret_cast<char *>(&distance), sizeof distance);) lower.push_back(distance);
    if (lower.empty()) {
        std::fprintf(stderr, "usage: ripser_pass FILE, where FILE has distances\n");
        return 2;
    }
    const auto points = size_t((1 + std::sqrt(1 + 8.0 * double(lower.size()))) / 2 + 0.5);
    std::vector<float> upper;
    upper.reserve(lower.size());
    for (size_t i = 0; i < points; i++)
        for (size_t j = i + 1; j < points; j++) upper.push_back(lower[j * (j - 1) / 2 + i]);
    lower = {};

    const float all = std::numeric_limits<float>::infinity();
    const ripserResults found = rips_dm(upper.data(), int(upper.size()), 2, 1, all, 0);
    const std::vector<float> &dots = found.births_and_deaths_by_dim[1];
    std::printf("[");
    for (size_t i = 0; i < dots.size(); i += 2) {
        std::printf(i ? ",[%.9g," : "[%.9g,", double(dots[i]));
        std::printf(std::isinf(dots[i + 1]) ? "1e999]" : "%.9g]", double(dots[i + 1]));
    }
    std::printf("]\n");
}
