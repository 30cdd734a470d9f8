// Reads the tables of tests/golden: rows of text fields, header dropped.
#pragma once

#include <fstream>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

typedef std::vector<std::string> Row;

inline std::vector<Row> golden(const std::string& name) {
    std::string here = __FILE__;
    here.erase(here.find_last_of('/') + 1);
    std::ifstream file(here + "../golden/" + name);
    if (!file) throw std::runtime_error("cannot read tests/golden/" + name);
    std::vector<Row> rows;
    std::string line, field;
    std::getline(file, line);
    while (std::getline(file, line)) {
        std::istringstream fields(line);
        Row row;
        while (std::getline(fields, field, ',')) row.push_back(field);
        rows.push_back(row);
    }
    return rows;
}
