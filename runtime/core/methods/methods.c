/* Methods by name. */
#include "methods/method.h"

#include <string.h>

#define LISTED(name) &name,
const struct method *const all_methods[] = {ALL_METHODS(LISTED) NULL};

const struct method *find_method(const char *name)
{
    for (const struct method *const *m = all_methods; *m; m++)
        if (!strcmp((*m)->name, name))
            return *m;
    return NULL;
}

int estimates_errors(const struct method *method)
{
    return method->estimates && method->measure;
}
