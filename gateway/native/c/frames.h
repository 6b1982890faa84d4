/* The frames of a DBC file, which the generated node_data.c defines. */
#ifndef FRAMES_H
#define FRAMES_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define FRAME_BYTES 8

struct signal {
    unsigned start, bits;         /* position and length in the frame, little-endian */
    double scale, offset;         /* value = scale * raw + offset */
    double low, high;             /* allowed raw values */
    double missing, error;        /* raw values that mean missing and error; -1: none */
    double fallback;              /* raw value sent without one of these */
    uint64_t named;               /* an enumeration: a bit for each raw value; 0: no enumeration */
    int role;                     /* a sent signal: the node's own value; -1: an output */
    size_t ref;                   /* value reference of the compensator's variable */
};

struct frame {
    uint32_t id;
    unsigned data_id;             /* included in the check value */
    unsigned cycle_start, cycle_bits; /* the cycle count */
    const struct signal *signals;
    size_t signal_count;
    size_t first; /* first of the signals' consecutive variables, check and counts last; or NONE */
};

/* Faults of a value; those of a frame are in node_data.h. */
enum value_fault { VALUE_GOOD, VALUE_MISSING, VALUE_ERROR, VALUE_OUT_OF_RANGE };

uint64_t bits_at(const unsigned char data[FRAME_BYTES], unsigned start, unsigned bits);
double raw_of(const struct signal *signal, double value);
enum value_fault value_of(
    const struct signal *signal, const unsigned char data[FRAME_BYTES], double *value);
void put_bits(unsigned char data[FRAME_BYTES], unsigned start, double raw);
unsigned char check_of(const unsigned char data[FRAME_BYTES], unsigned data_id);
/* Continues a CRC-32 over more bytes; begin with 0. */
uint32_t crc32_of(uint32_t crc, const unsigned char *bytes, size_t size);

#endif
