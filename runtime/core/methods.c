/* The list of integration methods. */
#include "method.h"

#include <string.h>

extern const struct method dop853, dopri5, gauss, radau;

const struct method *const all_methods[] = {&dop853, &gauss, &dopri5, &radau, NULL};

const struct method *find_method(const char *name)
{
    for (const struct method *const *m = all_methods; *m; m++)
        if (!strcmp((*m)->name, name))
            return *m;
    return NULL;
}
