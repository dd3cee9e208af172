// SPDX-License-Identifier: Apache-2.0
// Adds up the coverage of every board of a test run. Verilator counts by model and forgets with it, so each model hands
// its counts over before it goes; at the end of the process their sums are written in Verilator's own format.
#include <verilated_cov.h>

#include <cstdint>
#include <cstdlib>
#include <fstream>
#include <string>
#include <unordered_map>

namespace haptogram::sim {
void gather_coverage(VerilatedCovContext& model);

namespace {

class Sums {
public:
    ~Sums() {
        if (counts_.empty()) return;
        std::ofstream out(file_);
        out << "# SystemC::Coverage-3\n";
        for (const auto& [point, count] : counts_) out << point << ' ' << count << '\n';
    }

    void add(VerilatedCovContext& model) {
        if (file_.empty()) return;
        const std::string part = file_ + ".part";
        model.write(part.c_str());
        std::ifstream in(part);
        for (std::string line; std::getline(in, line);) {
            const std::size_t space = line.rfind(' ');  // C 'what and where' count
            if (line.starts_with("C ")) counts_[line.substr(0, space)] += std::stoull(line.substr(space));
        }
    }

private:
    static std::string file() {
        const char* name = std::getenv("HAPTOGRAM_COVERAGE");
        return name == nullptr ? "" : name;
    }

    std::string file_ = file();
    std::unordered_map<std::string, std::uint64_t> counts_;
};

}  // namespace

void gather_coverage(VerilatedCovContext& model) {
    static Sums sums;
    sums.add(model);
}

}  // namespace haptogram::sim
