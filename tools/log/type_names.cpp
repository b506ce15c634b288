#include "tools/log/type_names.hpp"
namespace marco::logs {
std::string type_name(uint64_t) { return ""; }
}  // namespace marco::logs
