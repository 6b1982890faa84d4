/* Encodes and decodes frames; check values: the twin of gateway.codec and gateway.protection. */
#include "frames.h"

#include <math.h>

uint64_t bits_at(const unsigned char data[FRAME_BYTES], unsigned start, unsigned bits)
{
    uint64_t all = 0;
    for (unsigned i = 0; i < FRAME_BYTES; i++) {
        all |= (uint64_t)data[i] << 8 * i;
    }
    return all >> start & (((uint64_t)1 << bits) - 1);
}

void put_bits(unsigned char data[FRAME_BYTES], unsigned start, double raw)
{
    uint64_t all = (uint64_t)raw << start;
    for (unsigned i = 0; i < FRAME_BYTES; i++) {
        data[i] |= (unsigned char)(all >> 8 * i);
    }
}

double raw_of(const struct signal *signal, double value)
{
    double raw = nearbyint((value - signal->offset) / signal->scale);
    double special = isnan(value) ? signal->missing : signal->error;
    if (isfinite(value) && signal->low <= raw && raw <= signal->high) {
        return raw;
    }
    return special >= 0.0 ? special : signal->fallback;
}

enum value_fault value_of(
    const struct signal *signal, const unsigned char data[FRAME_BYTES], double *value)
{
    double raw = (double)bits_at(data, signal->start, signal->bits);
    *value = NAN;
    if (raw == signal->missing) {
        return VALUE_MISSING;
    }
    if (raw == signal->error) {
        return VALUE_ERROR;
    }
    if ((signal->named != 0 && (raw > 63.0 || !(signal->named >> (unsigned)raw & 1u)))
        || raw < signal->low || raw > signal->high) {
        return VALUE_OUT_OF_RANGE;
    }
    *value = raw * signal->scale + signal->offset;
    return VALUE_GOOD;
}

static unsigned char crc8(unsigned crc)
{
    for (int bit = 0; bit < 8; bit++) {
        crc = crc & 0x80u ? crc << 1 ^ 0x1Du : crc << 1;
    }
    return (unsigned char)crc;
}

unsigned char check_of(const unsigned char data[FRAME_BYTES], unsigned data_id)
{
    unsigned char crc = crc8(crc8(data_id & 0xFFu) ^ data_id >> 8);
    for (int i = 1; i < FRAME_BYTES; i++) {
        crc = crc8((unsigned)(crc ^ data[i]));
    }
    return crc;
}

uint32_t crc32_of(uint32_t crc, const unsigned char *bytes, size_t size)
{
    crc = ~crc;
    for (size_t i = 0; i < size; i++) {
        crc ^= bytes[i];
        for (int bit = 0; bit < 8; bit++) {
            crc = crc & 1u ? crc >> 1 ^ 0xEDB88320u : crc >> 1;
        }
    }
    return ~crc;
}
