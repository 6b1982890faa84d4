/* The frames of a DBC file; the generated node_data.c says which. */
#ifndef FRAMES_H
#define FRAMES_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define FRAME_BYTES 8

struct signal {
    unsigned start, bits;         /* its place in the frame, the least significant bit first */
    double scale, offset;         /* value = scale * raw + offset */
    double low, high;             /* allowed raw values */
    double missing, error;        /* raw values that say so; -1: there is none */
    double fallback;              /* raw value of what is missing where nothing says so */
    uint64_t named;               /* of an enumeration: a bit for each raw value; 0: it is none */
    int role;                     /* of one that is sent: what the node itself says; -1: an output */
    size_t ref;                   /* value reference of the compensator's variable */
};

struct frame {
    uint32_t id;
    unsigned data_id;             /* enters the check value */
    unsigned cycle_start, cycle_bits; /* the count of cycles */
    const struct signal *signals;
    size_t signal_count;
    size_t first; /* variable of the signals, which stand in a row, check and counts last; NONE */
};

/* What is wrong with a value; the faults of a frame are in node_data.h. */
enum value_fault { VALUE_GOOD, VALUE_MISSING, VALUE_ERROR, VALUE_OUT_OF_RANGE };

uint64_t bits_at(const unsigned char data[FRAME_BYTES], unsigned start, unsigned bits);
double raw_of(const struct signal *signal, double value);
enum value_fault value_of(
    const struct signal *signal, const unsigned char data[FRAME_BYTES], double *value);
void put_bits(unsigned char data[FRAME_BYTES], unsigned start, double raw);
unsigned char check_of(const unsigned char data[FRAME_BYTES], unsigned data_id);
/* CRC-32 of more bytes; begin with 0. */
uint32_t crc32_of(uint32_t crc, const unsigned char *bytes, size_t size);

#endif
