/* What an instance of the compensator computes with, and what it remembers. */
#ifndef CONTENT_H
#define CONTENT_H

#include "compensator.h"

#define FILE_LENGTH 1024 /* of the text of the parameter model_file */

struct model {
    struct compensator compensator;
    struct content *next; /* of derivatives: the step that comes, */
    double *unit;         /* and a direction of one temperature */
};

struct content {
    struct output output;
    struct remembered remembered;
    char model_file[FILE_LENGTH];
    double numbers[]; /* of the compensator */
};

#endif
