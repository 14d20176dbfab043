// Print rx, ry (degrees) and depth (mm) of the newest reading: print_reading HOST PORT [TOKEN]
#include <exception>
#include <iostream>

#include "palpate_readings.hpp"

int main(int count, char** words) {
  if (count < 3) return 2;
  try {
    const auto reading = palpate::newest(words[1], std::atoi(words[2]), count > 3 ? words[3] : "");
    if (!reading.there) return 1;
    std::cout << reading.number("rx_deg") << " " << reading.number("ry_deg") << " " << reading.number("depth_mm") << "\n";
  } catch (const std::exception& error) {
    std::cerr << error.what() << "\n";
    return 3;
  }
}
