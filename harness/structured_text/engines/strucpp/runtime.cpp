/*
 * The harness's side of a program that STruC++ translated.
 *
 * What stands before this text is written for each program: the C++ of STruC++, one object of its
 * configuration, where its data lie (shim_regions), how blocks and structures are laid out
 * (shim_layout), and shim_programs, which runs the programs that are due.
 */
#include <cstring>
#include <exception>
#include <stdexcept>

#include "faults.h"

extern "C" {

/* Number of the next tick. */
unsigned long long shim_tick;

/* Whether variables lie in memory as the harness reads them: the value first, a text's length
   behind its characters. */
int shim_is_as_expected(void) {
  strucpp::IECVar<strucpp::INT_t> number(0x1234);
  strucpp::IECStringVar<254> text;
  short value;
  unsigned short length;
  text = "AB";
  const char *start = reinterpret_cast<const char *>(&text);
  std::memcpy(&value, &number, sizeof value);
  std::memcpy(&length, start + sizeof(strucpp::IECString<254>) - sizeof length, sizeof length);
  return value == 0x1234 && std::memcmp(start, "AB", 3) == 0 && length == 2;
}

void shim_start(void) {}

static const char *shim_run(void) {
  try {
    shim_programs(shim_tick);
    return nullptr;
  } catch (const std::out_of_range &) {
    return "an index of the program is out of range";
  } catch (const std::exception &error) {
    static char text[200];
    std::strncpy(text, error.what(), sizeof text - 1);
    return text;
  }
}

/* Runs one base tick; returns what went wrong, or NULL. */
const char *shim_scan(long long now_us) {
  strucpp::__CURRENT_TIME_NS = now_us * 1000;
  const char *wrong = shim_guarded(shim_run);
  shim_tick++;
  return wrong;
}
}
