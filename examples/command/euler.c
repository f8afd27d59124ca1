/* One step of a pendulum by the explicit Euler method, for every row of a file: euler BEFORE AFTER H.
 *
 * BEFORE and AFTER are .npz files, which are .zip archives of .npy arrays: here q and p of shape (samples, degrees of
 * freedom), doubles, little-endian, not compressed. Build it with: gcc -O2 -o euler euler.c -lm */

#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static void fail(const char *message) {
    fprintf(stderr, "euler: %s\n", message);
    exit(1);
}

static uint32_t number(const unsigned char *at, int bytes) {
    uint32_t value = 0;
    for (int k = bytes - 1; k >= 0; k--) value = value << 8 | at[k];
    return value;
}

/* A member of the archive `zip`, by the directory at its end; `size` is that of the archive, then that of the member. */
static const unsigned char *member(const unsigned char *zip, size_t *size, const char *name) {
    size_t end = *size;
    do {
        if (end < 22) fail("not an .npz file");
        end--;
    } while (end + 21 > *size - 1 || number(zip + end, 4) != 0x06054b50);
    size_t entry = number(zip + end + 16, 4);
    for (uint32_t left = number(zip + end + 10, 2); left > 0; left--) {
        size_t length = number(zip + entry + 28, 2);
        if (length == strlen(name) && memcmp(zip + entry + 46, name, length) == 0) {
            size_t local = number(zip + entry + 42, 4);
            if (number(zip + entry + 10, 2) != 0) fail("compressed arrays are not read");
            *size = number(zip + entry + 24, 4);
            return zip + local + 30 + number(zip + local + 26, 2) + number(zip + local + 28, 2);
        }
        entry += 46 + length + number(zip + entry + 30, 2) + number(zip + entry + 32, 2);
    }
    fail("no such array");
    return NULL;
}

/* The numbers of an array, and its header, which describes the shape. */
static double *array(const unsigned char *zip, size_t size, const char *name, size_t *header, size_t *count,
                     const unsigned char **start) {
    *start = member(zip, &size, name);
    *header = 10 + number(*start + 8, 2);
    *count = (size - *header) / sizeof(double);
    double *values = malloc(*count * sizeof(double));
    if (values == NULL) fail("out of memory");
    memcpy(values, *start + *header, *count * sizeof(double));
    return values;
}

static uint32_t checksum(const unsigned char *bytes, size_t size) {
    uint32_t crc = 0xffffffff;
    for (size_t k = 0; k < size; k++) {
        crc ^= bytes[k];
        for (int bit = 0; bit < 8; bit++) crc = crc >> 1 ^ (crc & 1 ? 0xedb88320 : 0);
    }
    return ~crc;
}

static void put(FILE *file, uint32_t value, int bytes) {
    for (int k = 0; k < bytes; k++) fputc(value >> 8 * k & 0xff, file);
}

/* The fields that the header before a member and its entry in the directory share. */
static void describe(FILE *file, uint32_t crc, uint32_t size) {
    put(file, 20, 2), put(file, 0, 2), put(file, 0, 2); /* version, flags, not compressed */
    put(file, 0, 2), put(file, 0x21, 2);                /* time and date */
    put(file, crc, 4), put(file, size, 4), put(file, size, 4);
    put(file, 5, 2), put(file, 0, 2); /* lengths of "q.npy" and of further fields */
}

int main(int argc, char **argv) {
    if (argc != 4) fail("usage: euler BEFORE AFTER H");
    double h = strtod(argv[3], NULL);

    FILE *file = fopen(argv[1], "rb");
    if (file == NULL) fail("cannot open the input");
    fseek(file, 0, SEEK_END);
    size_t size = (size_t)ftell(file);
    unsigned char *zip = malloc(size);
    rewind(file);
    if (zip == NULL || fread(zip, 1, size, file) != size) fail("cannot read the input");
    fclose(file);

    const char *names[2] = {"q.npy", "p.npy"};
    const unsigned char *start[2];
    double *values[2];
    size_t header[2], count[2];
    for (int k = 0; k < 2; k++) values[k] = array(zip, size, names[k], &header[k], &count[k], &start[k]);

    for (size_t k = 0; k < count[0]; k++) {
        double q = values[0][k], p = values[1][k];
        values[0][k] = q + h * p;
        values[1][k] = p - h * sin(q);
    }

    file = fopen(argv[2], "wb");
    if (file == NULL) fail("cannot open the output");
    uint32_t offset[3], crc[2], bytes[2];
    for (int k = 0; k < 2; k++) {
        bytes[k] = (uint32_t)(header[k] + count[k] * sizeof(double));
        unsigned char *npy = malloc(bytes[k]);
        if (npy == NULL) fail("out of memory");
        memcpy(npy, start[k], header[k]);
        memcpy(npy + header[k], values[k], count[k] * sizeof(double));
        crc[k] = checksum(npy, bytes[k]);
        offset[k] = (uint32_t)ftell(file);
        put(file, 0x04034b50, 4), describe(file, crc[k], bytes[k]);
        fputs(names[k], file);
        fwrite(npy, 1, bytes[k], file);
        free(npy);
        free(values[k]);
    }
    offset[2] = (uint32_t)ftell(file);
    for (int k = 0; k < 2; k++) {
        put(file, 0x02014b50, 4), put(file, 20, 2), describe(file, crc[k], bytes[k]);
        put(file, 0, 2), put(file, 0, 2), put(file, 0, 2), put(file, 0, 4), put(file, offset[k], 4);
        fputs(names[k], file);
    }
    uint32_t directory = (uint32_t)ftell(file) - offset[2];
    put(file, 0x06054b50, 4), put(file, 0, 4), put(file, 2, 2), put(file, 2, 2);
    put(file, directory, 4), put(file, offset[2], 4), put(file, 0, 2);
    free(zip);
    return fclose(file) == 0 ? 0 : 1;
}
